package crsm.spy;

import java.awt.BorderLayout;
import java.util.EnumSet;
import java.util.Set;
import javax.swing.JButton;
import javax.swing.JPanel;
import javax.swing.JToggleButton;
import javax.swing.JToolBar;

/** The map of a robot, and above it what to show. */
final class MapView extends JPanel {
  final MapCanvas canvas;

  MapView(RobotFollower follower) {
    super(new BorderLayout());
    Set<Layer> layers = EnumSet.allOf(Layer.class);
    canvas = new MapCanvas(follower, layers);
    JToolBar bar = new JToolBar();
    bar.setFloatable(false);
    for (Layer layer : Layer.values()) {
      JToggleButton button = new JToggleButton(layer.title, true);
      button.setToolTipText(layer.help);
      button.addActionListener(event -> {
        if (!layers.remove(layer)) layers.add(layer);
      });
      bar.add(button);
    }
    bar.addSeparator();
    addAim(bar, "Fit", "shows the whole map, like a double-click", MapCanvas.Aim.FIT);
    addAim(bar, "Follow", "keeps the laser in the middle until you drag the map", MapCanvas.Aim.FOLLOW);
    add(bar, BorderLayout.NORTH);
    add(canvas, BorderLayout.CENTER);
  }

  private void addAim(JToolBar bar, String title, String help, MapCanvas.Aim aim) {
    JButton button = new JButton(title);
    button.setToolTipText(help);
    button.addActionListener(event -> canvas.aimAt(aim));
    bar.add(button);
  }
}
