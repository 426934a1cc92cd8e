package crsm.spy;

import java.awt.geom.AffineTransform;

/** Which part of the map frame a picture shows: x right, y up. */
final class Viewport {
  private static final double LEAST_PIXELS_PER_M = 0.05;
  private static final double MOST_PIXELS_PER_M = 5000;

  private double left_m = -10;  // of the picture's upper left corner
  private double top_m = 10;
  private double pixels_per_m = 40;

  double pixelsPerM() {
    return pixels_per_m;
  }

  double toXM(double x_pixels) {
    return left_m + x_pixels / pixels_per_m;
  }

  double toYM(double y_pixels) {
    return top_m - y_pixels / pixels_per_m;
  }

  double toX(double x_m) {
    return (x_m - left_m) * pixels_per_m;
  }

  double toY(double y_m) {
    return (top_m - y_m) * pixels_per_m;
  }

  /** From the map frame [m] to pixels. */
  AffineTransform toPixels() {
    return new AffineTransform(pixels_per_m, 0, 0, -pixels_per_m, -left_m * pixels_per_m, top_m * pixels_per_m);
  }

  void moveByPixels(double x_pixels, double y_pixels) {
    left_m -= x_pixels / pixels_per_m;
    top_m += y_pixels / pixels_per_m;
  }

  /** The point below these pixels stays there. */
  void zoom(double factor, double x_pixels, double y_pixels) {
    double x_m = toXM(x_pixels);
    double y_m = toYM(y_pixels);
    pixels_per_m = Math.max(LEAST_PIXELS_PER_M, Math.min(MOST_PIXELS_PER_M, factor * pixels_per_m));
    left_m = x_m - x_pixels / pixels_per_m;
    top_m = y_m + y_pixels / pixels_per_m;
  }

  /** Puts a point into the middle of a picture of that size. */
  void center(double x_m, double y_m, int width_pixels, int height_pixels) {
    moveByPixels(0.5 * width_pixels - toX(x_m), 0.5 * height_pixels - toY(y_m));
  }

  /** One cell of the map is one pixel, and the picture's upper left corner is that of this cell. */
  void showCells(double cell_size_m, int left_cell, int top_cell) {
    pixels_per_m = 1 / cell_size_m;
    left_m = left_cell * cell_size_m;
    top_m = (top_cell + 1) * cell_size_m;
  }

  /** Shows all tiles of a map in a picture of that size, with a strip of it left free above and below. */
  void fit(TileMap map, int width_pixels, int height_pixels, int strip_pixels) {
    if (map.isEmpty()) return;
    double free_pixels = Math.max(1, height_pixels - 2 * strip_pixels);
    double wanted = Math.min(0.95 * width_pixels / map.widthM(), free_pixels / map.heightM());
    zoom(wanted / pixels_per_m, 0, 0);
    center(map.leftM() + 0.5 * map.widthM(), map.bottomM() + 0.5 * map.heightM(), width_pixels, height_pixels);
  }
}
