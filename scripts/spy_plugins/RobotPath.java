package crsm.spy;

import java.awt.geom.Path2D;

/** Where the robot was, thinned out to what a picture shows: its memory has a limit, however far the robot drives. */
final class RobotPath {
  private static final int MOST_POINTS = 1 << 14;

  private double spacing_m = 0.02;  // less than a pixel of most pictures
  private final float[] x_m = new float[MOST_POINTS];
  private final float[] y_m = new float[MOST_POINTS];
  private final boolean[] floating = new boolean[MOST_POINTS];
  private int num_points = 0;
  private double length_m = 0;   // on the map that is shown
  private int last_trajectory = 0;

  /** Lost scans have no place; those that float have one in a frame of their own. */
  void add(ScanMatch match) {
    if (match.isLost()) return;
    boolean goes_on = match.trajectory == last_trajectory;  // how the robot came to another one is not known
    last_trajectory = match.trajectory;
    if (num_points > 0 && match.floating == floating[num_points - 1] && goes_on) {
      double step_m = Math.hypot(match.x_m - x_m[num_points - 1], match.y_m - y_m[num_points - 1]);
      if (step_m < spacing_m) return;
      if (!match.floating) length_m += step_m;
    }
    if (num_points == MOST_POINTS) thin();
    floating[num_points] = match.floating;
    x_m[num_points] = (float) match.x_m;
    y_m[num_points++] = (float) match.y_m;
  }

  /** Keeps every other point, and from now on only what is twice as far apart. */
  private void thin() {
    for (int i = 0; 2 * i < num_points; ++i) {
      x_m[i] = x_m[2 * i];
      y_m[i] = y_m[2 * i];
      floating[i] = floating[2 * i];
    }
    num_points = (num_points + 1) / 2;
    spacing_m *= 2;
  }

  boolean isEmpty() {
    return num_points == 0;
  }

  int numPoints() {
    return num_points;
  }

  double lengthM() {
    return length_m;
  }

  double startXM() {
    return x_m[0];
  }

  double startYM() {
    return y_m[0];
  }

  /** What floats, or what does not, in the map frame [m]. */
  Path2D outline(boolean of_floating) {
    Path2D outline = new Path2D.Double();
    for (int i = 0; i < num_points; ++i) {
      if (floating[i] != of_floating) continue;
      if (i == 0 || floating[i - 1] != of_floating) outline.moveTo(x_m[i], y_m[i]);
      else outline.lineTo(x_m[i], y_m[i]);
    }
    return outline;
  }
}
