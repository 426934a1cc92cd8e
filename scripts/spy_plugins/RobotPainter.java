package crsm.spy;

import crsm.scan_match_t;
import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.geom.AffineTransform;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.awt.geom.Path2D;
import java.util.Set;

/** Draws where a robot is, where it was, and what its laser sees. */
final class RobotPainter {
  static final Color PATH = new Color(20, 100, 210);
  static final Color FLOATING = new Color(120, 160, 0);
  static final Color START = new Color(30, 160, 50);
  static final Color HIT = new Color(200, 30, 200);
  static final Color RAY_ON_WALL = new Color(0, 150, 70);
  static final Color RAY_IN_UNEXPLORED = new Color(235, 140, 0);
  static final Color RAY_ON_FREE = new Color(220, 30, 40);
  private static final double STANDARD_DEVIATIONS = Math.sqrt(5.991);  // that hold 95 % in two dimensions

  private final Graphics2D g;
  private final Viewport view;
  private final Robot robot;

  RobotPainter(Graphics2D g, Viewport view, Robot robot) {
    this.g = g;
    this.view = view;
    this.robot = robot;
  }

  static Color colourOf(ScanMatch match) {
    if (match.floating) return FLOATING;
    if (match.isLost()) return RAY_ON_FREE;
    return match.state == scan_match_t.DEGENERATE ? RAY_IN_UNEXPLORED : START;
  }

  static void paintPath(Graphics2D g, Viewport view, RobotPath path) {
    if (path.isEmpty()) return;
    g.setColor(PATH);
    g.setStroke(new BasicStroke(2, BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND));
    g.draw(view.toPixels().createTransformedShape(path.outline(false)));
    g.setColor(FLOATING);
    g.setStroke(new BasicStroke(2, BasicStroke.CAP_BUTT, BasicStroke.JOIN_ROUND, 10, new float[] {7, 5}, 0));
    g.draw(view.toPixels().createTransformedShape(path.outline(true)));
    paintDisc(g, view, path.startXM(), path.startYM(), 6, START);
  }

  private static void paintDisc(Graphics2D g, Viewport view, double x_m, double y_m, double radius, Color colour) {
    g.setColor(colour);
    g.fill(new Ellipse2D.Double(view.toX(x_m) - radius, view.toY(y_m) - radius, 2 * radius, 2 * radius));
  }

  /** All but what belongs to the map's version, which is path and map. */
  void paint(Set<Layer> layers) {
    ScanMatch match = robot.match();
    if (match == null) return;
    if (layers.contains(Layer.HITS)) paintRays(match, false);
    if (layers.contains(Layer.CRITICAL_RAYS)) paintRays(match, true);
    if (layers.contains(Layer.UNCERTAINTY)) paintUncertainty(match);
    paintLaser(match);
  }

  private void paintRays(ScanMatch match, boolean critical) {
    ScanRays rays = robot.rays();
    if (rays == null) return;
    g.setStroke(new BasicStroke(1));
    double sin = Math.sin(match.yaw_rad);
    double cos = Math.cos(match.yaw_rad);
    for (int i = 0; i < rays.range_m.length; ++i) {
      // From where the laser stood when it measured the ray.
      double time_s = rays.time_s[i];
      double forward_m = match.twist[0] * time_s;
      double left_m = match.twist[1] * time_s;
      double angle_rad = match.yaw_rad + match.twist[2] * time_s + rays.angle_rad[i];
      double x_m = match.x_m + cos * forward_m - sin * left_m + rays.range_m[i] * Math.cos(angle_rad);
      double y_m = match.y_m + sin * forward_m + cos * left_m + rays.range_m[i] * Math.sin(angle_rad);
      if (!critical) {
        paintDisc(g, view, x_m, y_m, 1.5, HIT);
      } else if (rays.is_critical[i]) {
        Color colour = colourOfEnd(x_m, y_m);
        g.setColor(new Color(colour.getRed(), colour.getGreen(), colour.getBlue(), 120));
        g.draw(new Line2D.Double(view.toX(match.x_m), view.toY(match.y_m), view.toX(x_m), view.toY(y_m)));
        paintDisc(g, view, x_m, y_m, 3, colour);
      }
    }
  }

  /** By the most occupied of the cell and its neighbours: a wall that is seen once more is hit within a cell. */
  private Color colourOfEnd(double x_m, double y_m) {
    TileMap map = robot.replica.map();
    int cell_x = map.cellAt(x_m);
    int cell_y = map.cellAt(y_m);
    int least = 255;
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) least = Math.min(least, map.at(cell_x + x, cell_y + y));
    }
    if (least == TileMap.UNEXPLORED) return RAY_IN_UNEXPLORED;
    return least < TileMap.UNEXPLORED ? RAY_ON_WALL : RAY_ON_FREE;
  }

  /** The eigenvectors of the position's covariance are the axes of the ellipse. */
  private void paintUncertainty(ScanMatch match) {
    if (match.isUnknown()) return;
    double long_m = STANDARD_DEVIATIONS * match.sigmaAlongM();
    double short_m = STANDARD_DEVIATIONS * match.sigmaAcrossM();
    AffineTransform to_pixels = view.toPixels();
    to_pixels.translate(match.x_m, match.y_m);
    to_pixels.rotate(match.alongRad());
    g.setColor(colourOf(match));
    g.setStroke(new BasicStroke(1.5f));
    g.draw(to_pixels.createTransformedShape(new Ellipse2D.Double(-long_m, -short_m, 2 * long_m, 2 * short_m)));
    if (match.state != scan_match_t.DEGENERATE) return;
    double reach_m = 60 / view.pixelsPerM();
    double x_m = reach_m * match.degenerate_axis[0];
    double y_m = reach_m * match.degenerate_axis[1];
    g.setStroke(new BasicStroke(2, BasicStroke.CAP_BUTT, BasicStroke.JOIN_MITER, 10, new float[] {8, 5}, 0));
    g.draw(new Line2D.Double(view.toX(match.x_m - x_m), view.toY(match.y_m - y_m), view.toX(match.x_m + x_m),
                             view.toY(match.y_m + y_m)));
  }

  /** An arrow head of the same size at every zoom. */
  private void paintLaser(ScanMatch match) {
    Path2D head = new Path2D.Double();
    head.moveTo(14, 0);
    head.lineTo(-9, 9);
    head.lineTo(-4, 0);
    head.lineTo(-9, -9);
    head.closePath();
    AffineTransform place = AffineTransform.getTranslateInstance(view.toX(match.x_m), view.toY(match.y_m));
    place.rotate(-match.yaw_rad);
    head.transform(place);
    g.setColor(colourOf(match));
    g.fill(head);
    g.setColor(Color.WHITE);
    g.setStroke(new BasicStroke(1.5f));
    g.draw(head);
  }
}
