package crsm.spy;

import java.awt.image.BufferedImage;
import java.awt.image.DataBufferInt;
import java.util.Arrays;

/** Paints the cells of a map into a picture. */
final class MapPainter {
  /** Of a cell's byte, as red, green and blue. */
  static final int[] COLOUR = makeColours();

  private MapPainter() {}

  /** Free is white, occupied is black, and unexplored, the byte that nothing else has, a colour of its own. */
  private static int[] makeColours() {
    int[] colours = new int[256];
    for (int value = 0; value < 256; ++value) colours[value] = value << 16 | value << 8 | value;
    colours[TileMap.UNEXPLORED] = 0xc3ccd8;
    return colours;
  }

  /**
   * image: TYPE_INT_RGB. Where several cells share a pixel it shows the most occupied one, so that walls stay to be
   * seen from afar.
   */
  static void paint(TileMap map, Viewport view, BufferedImage image) {
    int width = image.getWidth();
    int height = image.getHeight();
    int[] pixels = ((DataBufferInt) image.getRaster().getDataBuffer()).getData();
    Arrays.fill(pixels, COLOUR[TileMap.UNEXPLORED]);
    if (map.isEmpty()) return;
    int[] first_x = new int[width];
    int[] end_x = new int[width];
    for (int x = 0; x < width; ++x) {
      first_x[x] = firstCell(map, view.toXM(x), view.toXM(x + 1));
      end_x[x] = endCell(map, view.toXM(x), view.toXM(x + 1));
    }
    for (int y = 0; y < height; ++y) {
      int first_y = firstCell(map, view.toYM(y + 1), view.toYM(y));
      int end_y = endCell(map, view.toYM(y + 1), view.toYM(y));
      for (int x = 0; x < width; ++x) {
        pixels[y * width + x] = COLOUR[mostOccupied(map, first_x[x], end_x[x], first_y, end_y)];
      }
    }
  }

  /** Of the cells whose middle a pixel covers, or else the one that its own middle is in. */
  private static int firstCell(TileMap map, double low_m, double high_m) {
    int first = map.cellAt(low_m + 0.5 * map.cell_size_m);
    return first < map.cellAt(high_m + 0.5 * map.cell_size_m) ? first : map.cellAt(0.5 * (low_m + high_m));
  }

  private static int endCell(TileMap map, double low_m, double high_m) {
    int end = map.cellAt(high_m + 0.5 * map.cell_size_m);
    return map.cellAt(low_m + 0.5 * map.cell_size_m) < end ? end : map.cellAt(0.5 * (low_m + high_m)) + 1;
  }

  /** Of the explored ones among these cells; unexplored if none is. */
  private static int mostOccupied(TileMap map, int first_x, int end_x, int first_y, int end_y) {
    if (map.hasNoTile(first_x, end_x, first_y, end_y)) return TileMap.UNEXPLORED;  // most of many a picture
    int least = 256;
    for (int y = first_y; y < end_y; ++y) {
      for (int x = first_x; x < end_x; ++x) {
        int value = map.at(x, y);
        if (value < least && value != TileMap.UNEXPLORED) least = value;
      }
    }
    return least == 256 ? TileMap.UNEXPLORED : least;
  }
}
