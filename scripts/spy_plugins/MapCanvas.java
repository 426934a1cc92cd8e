package crsm.spy;

import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.Point;
import java.awt.event.MouseAdapter;
import java.awt.event.MouseEvent;
import java.awt.event.MouseWheelEvent;
import java.awt.image.BufferedImage;
import java.util.List;
import java.util.Set;
import javax.swing.JPanel;

/** Draws a robot on its map. The wheel zooms, dragging moves, a double-click shows all. */
final class MapCanvas extends JPanel {
  /** Which part of the map is shown. */
  enum Aim { FIT, FOLLOW, FREE }

  private static final double ZOOM_STEP = 1.2;
  private static final int STRIP_PIXELS = 75;  // above and below a map that fits: for the text

  final RobotFollower follower;
  private final Set<Layer> layers;
  private final Viewport view = new Viewport();
  private Aim aim = Aim.FIT;
  private Point mouse = null;  // null: outside

  private BufferedImage background;     // map, grid and path
  private List<Object> background_key;  // all that it depends on

  MapCanvas(RobotFollower follower, Set<Layer> layers) {
    this.follower = follower;
    this.layers = layers;
    MouseAdapter listener = new Listener();
    addMouseListener(listener);
    addMouseMotionListener(listener);
    addMouseWheelListener(listener);
  }

  void aimAt(Aim aim) {
    this.aim = aim;
  }

  private final class Listener extends MouseAdapter {
    @Override
    public void mouseClicked(MouseEvent event) {
      if (event.getClickCount() == 2) aim = Aim.FIT;
    }

    @Override
    public void mouseWheelMoved(MouseWheelEvent event) {
      if (aim == Aim.FIT) aim = Aim.FREE;
      view.zoom(Math.pow(ZOOM_STEP, -event.getPreciseWheelRotation()), event.getX(), event.getY());
    }

    @Override
    public void mousePressed(MouseEvent event) {
      mouse = event.getPoint();
    }

    @Override
    public void mouseDragged(MouseEvent event) {
      aim = Aim.FREE;
      if (mouse != null) view.moveByPixels(event.getX() - mouse.x, event.getY() - mouse.y);
      mouse = event.getPoint();
    }

    @Override
    public void mouseMoved(MouseEvent event) {
      mouse = event.getPoint();
    }

    @Override
    public void mouseExited(MouseEvent event) {
      mouse = null;
    }
  }

  @Override
  protected void paintComponent(Graphics graphics) {
    Graphics2D g = (Graphics2D) graphics;
    Robot robot = follower.robot;
    synchronized (robot) {
      point(robot);
      paintBackground(robot);
      g.drawImage(background, 0, 0, null);
      Drawing.smooth(g);
      new RobotPainter(g, view, robot).paint(layers);
      if (layers.contains(Layer.TEXT)) new TextPainter(g, getWidth(), getHeight()).paint(follower, view, mouse);
    }
  }

  /** Moves the view to where it is to be. */
  private void point(Robot robot) {
    ScanMatch match = robot.match();
    if (aim == Aim.FIT) view.fit(robot.replica.map(), getWidth(), getHeight(), STRIP_PIXELS);
    if (aim == Aim.FOLLOW && match != null) view.center(match.x_m, match.y_m, getWidth(), getHeight());
  }

  private void paintBackground(Robot robot) {
    List<Object> key = List.of(getWidth(), getHeight(), view.toPixels(), robot.replica.numPages(),
                               robot.replica.epoch(), layers.contains(Layer.GRID), layers.contains(Layer.PATH));
    if (key.equals(background_key)) return;
    background_key = key;
    if (background == null || background.getWidth() != getWidth() || background.getHeight() != getHeight()) {
      background = new BufferedImage(getWidth(), getHeight(), BufferedImage.TYPE_INT_RGB);
    }
    MapPainter.paint(robot.replica.map(), view, background);
    Graphics2D g = background.createGraphics();
    Drawing.smooth(g);
    if (layers.contains(Layer.GRID)) GridPainter.paint(g, view, getWidth(), getHeight());
    if (layers.contains(Layer.PATH)) RobotPainter.paintPath(g, view, robot.replica.path());
    g.dispose();
  }
}
