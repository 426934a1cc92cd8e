package crsm.spy;

import java.awt.Component;
import java.awt.Container;
import java.awt.Frame;
import java.io.BufferedReader;
import java.io.InputStreamReader;
import java.io.PrintStream;
import java.nio.file.Path;
import java.util.HashMap;
import java.util.Map;
import javax.swing.JInternalFrame;
import javax.swing.JTable;
import javax.swing.SwingUtilities;

/**
 * lcm-spy, in which channels are double-clicked. Reads lines: "open CHANNEL" waits for it, and says the title of the
 * view that it opens; "settle CHANNEL" and "compare CHANNEL FOLDER" are of that view's map as in FollowedMap.
 */
final class OpenedViews {
  private static final int POLL_MS = 50;

  private final Map<String, RobotFollower> followers = new HashMap<>();

  private OpenedViews() {}

  public static void main(String[] arguments) throws Exception {
    PrintStream answers = System.out;
    System.setOut(System.err);  // lcm-spy says things, too
    lcm.spy.Spy.main(new String[0]);
    OpenedViews views = new OpenedViews();
    BufferedReader input = new BufferedReader(new InputStreamReader(System.in));
    for (String line = input.readLine(); line != null; line = input.readLine()) {
      answers.println(views.answer(line.split(" ")));
    }
    System.exit(0);  // what the windows run on would go on
  }

  private String answer(String[] words) throws Exception {
    switch (words[0]) {
      case "open": return open(words[1]);
      case "settle": return FollowedMap.settle(followers.get(words[1]).robot);
      case "compare": return FollowedMap.compare(followers.get(words[1]).robot, Path.of(words[2]));
      default: throw new IllegalArgumentException(words[0]);
    }
  }

  private String open(String channel) throws Exception {
    String[] title = new String[1];
    while (title[0] == null) {
      Thread.sleep(POLL_MS);
      SwingUtilities.invokeAndWait(() -> title[0] = openIfThere(channel));
    }
    return title[0];
  }

  /** null while the channel has not come. */
  private String openIfThere(String channel) {
    JTable table = SpyScreenshot.findTable(Frame.getFrames()[0]);
    for (int row = 0; row < table.getRowCount(); ++row) {
      if (!SpyScreenshot.cell(table, row, "Channel").equals(channel)) continue;
      SpyScreenshot.doubleClick(table, row);
      Frame[] frames = Frame.getFrames();
      MapView view = find(MapView.class, frames[frames.length - 1]);
      followers.put(channel, view.canvas.follower);
      return find(JInternalFrame.class, frames[frames.length - 1]).getTitle();
    }
    return null;
  }

  private static <T> T find(Class<T> type, Container container) {
    for (Component component : container.getComponents()) {
      if (type.isInstance(component)) return type.cast(component);
      T found = component instanceof Container ? find(type, (Container) component) : null;
      if (found != null) return found;
    }
    return null;
  }
}
