package crsm.spy;

import bot_core.pose_t;
import crsm.critical_rays_t;
import crsm.map_delta_t;
import crsm.map_page_t;
import java.awt.Dimension;
import java.awt.event.ActionEvent;
import java.io.IOException;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import javax.swing.JOptionPane;
import javax.swing.SwingUtilities;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** Draws map, path, robot and rays of a robot when its map, its pose or its rays are double-clicked in lcm-spy. */
public class MapPlugin implements SpyPlugin {
  private static final String[] CHANNELS = {"MAP_DELTA", "MAP_PAGE", "WHOLE_MAP", "CRITICAL_RAYS", "TRUE_POSE",
                                            "POSE_LOCAL", "POSE", "ODOMETRY"};

  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == map_delta_t.LCM_FINGERPRINT || fingerprint == map_page_t.LCM_FINGERPRINT ||
           fingerprint == pose_t.LCM_FINGERPRINT || fingerprint == critical_rays_t.LCM_FINGERPRINT;
  }

  /** lcm-spy also asks with nulls, for the name. */
  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction("Map view") {
      @Override
      public void actionPerformed(ActionEvent event) {
        open(desktop, findPrefix(channel.name));
      }
    };
  }

  private static void open(JDesktopPane desktop, String prefix) {
    try {
      RobotFollower follower = new RobotFollower(findUrl(System.getProperty("sun.java.command", "")), prefix);
      SwingUtilities.getWindowAncestor(desktop).setSize(new Dimension(1000, 800));
      String title = prefix.isEmpty() ? "Map view" : "Map view of " + prefix;
      PluginWindow.open(desktop, title, new MapView(follower), follower::close);
    } catch (IOException unreachable) {
      JOptionPane.showMessageDialog(desktop, "Cannot connect to the bus: " + unreachable.getMessage());
    }
  }

  /** What a robot's channels begin with: "robot1/" of "robot1/MAP_DELTA". */
  static String findPrefix(String channel) {
    for (String name : CHANNELS) {
      if (channel.endsWith(name)) return channel.substring(0, channel.length() - name.length());
    }
    return channel.substring(0, channel.lastIndexOf('/') + 1);
  }

  /** The URL that lcm-spy was started with, which it tells no plugin; null: none, so that LCM's default holds. */
  static String findUrl(String command) {
    String[] words = command.split(" ");
    String url = null;
    for (int i = 0; i < words.length; ++i) {
      boolean next = words[i].equals("-l") || words[i].equals("--lcm-url");
      if (next && i + 1 < words.length) url = words[i + 1];
      if (words[i].startsWith("--lcm-url=")) url = words[i].substring("--lcm-url=".length());
    }
    return url;
  }
}
