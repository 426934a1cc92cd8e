package crsm.spy;

import static crsm.spy.Tests.check;
import static crsm.spy.Tests.checkEqual;
import static crsm.spy.Tests.test;

import bot_core.pose_t;
import crsm.map_delta_t;
import crsm.map_page_t;
import java.awt.image.BufferedImage;

/** What is drawn where. */
final class ViewTest {
  private ViewTest() {}

  static void run() {
    test("a cell is a pixel, x right, y up", ViewTest::cellIsPixel);
    test("from afar a pixel shows the most occupied of its cells", ViewTest::fromAfar);
    test("from nearby a cell fills its pixels and no others", ViewTest::fromNearby);
    test("what is below the mouse stays there while it zooms", ViewTest::zoomStays);
    test("all of a map fits into the picture", ViewTest::fits);
    test("the view opens on map and pose, with the robot's prefix", ViewTest::prefixes);
    test("the bus is the one that lcm-spy was started with", ViewTest::urls);
  }

  /** Cell (3, 5) is occupied, (4, 5) free, and all others are unexplored. */
  private static TileMap map() {
    TileMap map = new TileMap(0.1);
    MapPage.TileChange change = new MapPage.TileChange();
    int skip = 5 * TileMap.TILE_SIDE + 3;
    change.runs = new byte[] {(byte) (skip >> 8), (byte) skip, 0, 2, 0, (byte) 255};
    check(map.apply(change), "the tile is refused");
    return map;
  }

  private static int[] paint(Viewport view, int width, int height) {
    BufferedImage image = new BufferedImage(width, height, BufferedImage.TYPE_INT_RGB);
    MapPainter.paint(map(), view, image);
    int[] colours = image.getRGB(0, 0, width, height, null, 0, width);
    for (int i = 0; i < colours.length; ++i) colours[i] &= 0xffffff;
    return colours;
  }

  private static void cellIsPixel() {
    Viewport view = new Viewport();
    view.showCells(0.1, 0, 9);
    int[] colours = paint(view, 10, 10);
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 10; ++x) {
        int expected = y == 5 && x == 3 ? 0 : y == 5 && x == 4 ? 0xffffff : MapPainter.COLOUR[TileMap.UNEXPLORED];
        checkEqual(colours[(9 - y) * 10 + x], expected, "cell " + x + ", " + y);
      }
    }
  }

  private static void fromAfar() {
    Viewport view = new Viewport();
    view.showCells(0.8, 0, 0);  // 8 x 8 cells a pixel
    checkEqual(paint(view, 1, 1)[0], 0, "colour");
    view.showCells(0.2, 2, 2);  // cell (4, 5) and three that are unexplored
    checkEqual(paint(view, 1, 1)[0], 0xffffff, "colour");
  }

  private static void fromNearby() {
    Viewport view = new Viewport();
    view.showCells(0.025, 12, 23);  // cell (3, 5) begins at 12, 20
    int[] colours = paint(view, 12, 4);
    for (int i = 0; i < colours.length; ++i) {
      int expected = i % 12 < 4 ? 0 : i % 12 < 8 ? 0xffffff : MapPainter.COLOUR[TileMap.UNEXPLORED];
      checkEqual(colours[i], expected, "pixel " + i);
    }
  }

  private static void zoomStays() {
    Viewport view = new Viewport();
    double x_m = view.toXM(70);
    double y_m = view.toYM(30);
    view.zoom(3, 70, 30);
    check(Math.abs(view.toXM(70) - x_m) < 1e-9 && Math.abs(view.toYM(30) - y_m) < 1e-9, "it moved");
    checkEqual(view.pixelsPerM(), 120.0, "pixels per metre");
  }

  private static void fits() {
    Viewport view = new Viewport();
    view.fit(map(), 300, 200, 20);
    check(view.toX(0) >= 0 && view.toX(6.4) <= 300 && view.toY(6.4) >= 19.9 && view.toY(0) <= 180.1, "it does not");
    check(view.toY(0) - view.toY(6.4) > 159, "it is too small");
    view.fit(map(), 100, 1, 20);
    check(view.pixelsPerM() > 0, "a window that is hardly there");
  }

  private static void prefixes() {
    MapPlugin plugin = new MapPlugin();
    check(plugin.canHandle(map_delta_t.LCM_FINGERPRINT) && plugin.canHandle(map_page_t.LCM_FINGERPRINT) &&
          plugin.canHandle(pose_t.LCM_FINGERPRINT), "it does not");
    checkEqual(MapPlugin.findPrefix("MAP_DELTA"), "", "prefix");
    checkEqual(MapPlugin.findPrefix("robot1/TRUE_POSE"), "robot1/", "prefix");
    checkEqual(MapPlugin.findPrefix("r2POSE_LOCAL"), "r2", "prefix");
    checkEqual(MapPlugin.findPrefix("robot1/SOMEBODY"), "robot1/", "prefix");
  }

  private static void urls() {
    check(MapPlugin.findUrl("lcm.spy.Spy") == null, "there is one");
    for (String flags : new String[] {"-l udpm://x", "--lcm-url udpm://x", "--lcm-url=udpm://x"}) {
      checkEqual(MapPlugin.findUrl("lcm.spy.Spy " + flags), "udpm://x", flags);
    }
  }
}
