package crsm.spy;

import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.geom.Line2D;
import java.text.DecimalFormat;

/** Lines 1, 2 or 5 times a power of ten metres apart, and below them how long that is. */
final class GridPainter {
  private static final double MOST_PIXELS = 120;  // between lines
  private static final Color LINES = new Color(90, 110, 140, 60);
  private static final Color INK = new Color(40, 40, 40);
  private static final int MARGIN_PIXELS = 14;

  private GridPainter() {}

  static void paint(Graphics2D g, Viewport view, int width_pixels, int height_pixels) {
    double step_m = Drawing.roundLengthM(MOST_PIXELS / view.pixelsPerM());
    g.setColor(LINES);
    for (double x_m = step_m * Math.ceil(view.toXM(0) / step_m); view.toX(x_m) < width_pixels; x_m += step_m) {
      g.draw(new Line2D.Double(view.toX(x_m), 0, view.toX(x_m), height_pixels));
    }
    for (double y_m = step_m * Math.floor(view.toYM(0) / step_m); view.toY(y_m) < height_pixels; y_m -= step_m) {
      g.draw(new Line2D.Double(0, view.toY(y_m), width_pixels, view.toY(y_m)));
    }
    paintScale(g, step_m, width_pixels - MARGIN_PIXELS, height_pixels - MARGIN_PIXELS, view.pixelsPerM());
  }

  private static void paintScale(Graphics2D g, double length_m, int right, int bottom, double pixels_per_m) {
    double left = right - length_m * pixels_per_m;
    g.setColor(INK);
    g.draw(new Line2D.Double(left, bottom, right, bottom));
    for (double x : new double[] {left, right}) g.draw(new Line2D.Double(x, bottom - 4, x, bottom + 4));
    g.drawString(new DecimalFormat("0.### m").format(length_m), (float) left, bottom - 7);
  }
}
