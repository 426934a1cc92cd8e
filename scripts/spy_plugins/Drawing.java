package crsm.spy;

import java.awt.Graphics2D;
import java.awt.RenderingHints;

/** What several views draw alike. */
final class Drawing {
  private Drawing() {}

  static void smooth(Graphics2D g) {
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_STROKE_CONTROL, RenderingHints.VALUE_STROKE_PURE);
  }

  /** The largest of 1, 2 or 5 times a power of ten metres that is no longer than that. */
  static double roundLengthM(double longest_m) {
    double power_m = Math.pow(10, Math.floor(Math.log10(longest_m)));
    double factor = longest_m / power_m;
    return power_m * (factor < 2 ? 1 : factor < 5 ? 2 : 5);
  }
}
