package crsm.spy;

import java.util.Arrays;

/** The map: tiles of 64 x 64 cells, one byte each: 255 free .. 0 occupied, 127 unexplored. */
final class TileMap {
  private static final int TILE_BITS = 6;
  static final int TILE_SIDE = 1 << TILE_BITS;
  static final int TILE_CELLS = TILE_SIDE * TILE_SIDE;
  static final int UNEXPLORED = 127;

  // The limits of every map, of its owner's as well; so they also limit what a replica may take of memory.
  static final int MOST_TILES = 1 << 14;
  private static final int MOST_TILES_IN_RECTANGLE = 1 << 16;
  private static final int MAX_TILE = 1024;

  final double cell_size_m;
  private byte[][] tiles = {};  // of a rectangle, row by row from the lower left; null where nothing was explored
  private int low_x, low_y;     // of the rectangle
  private int width, height;
  private int num_tiles;

  TileMap(double cell_size_m) {
    this.cell_size_m = cell_size_m;
  }

  boolean isEmpty() {
    return num_tiles == 0;
  }

  int numTiles() {
    return num_tiles;
  }

  /** Of the rectangle around all tiles [m]. */
  double leftM() {
    return low_x * TILE_SIDE * cell_size_m;
  }

  double bottomM() {
    return low_y * TILE_SIDE * cell_size_m;
  }

  double widthM() {
    return width * TILE_SIDE * cell_size_m;
  }

  double heightM() {
    return height * TILE_SIDE * cell_size_m;
  }

  /** Cells row by row from the lower left; null where nothing was explored. */
  private byte[] tile(int tile_x, int tile_y) {
    int column = tile_x - low_x;
    int row = tile_y - low_y;
    return column >= 0 && column < width && row >= 0 && row < height ? tiles[row * width + column] : null;
  }

  int at(int cell_x, int cell_y) {
    byte[] cells = tile(cell_x >> TILE_BITS, cell_y >> TILE_BITS);  // shifts of negative numbers round down
    if (cells == null) return UNEXPLORED;
    return cells[(cell_y & TILE_SIDE - 1) << TILE_BITS | cell_x & TILE_SIDE - 1] & 0xff;
  }

  /** Whether no tile is there of any of these cells. */
  boolean hasNoTile(int first_x, int end_x, int first_y, int end_y) {
    for (int y = first_y >> TILE_BITS; y <= end_y - 1 >> TILE_BITS; ++y) {
      for (int x = first_x >> TILE_BITS; x <= end_x - 1 >> TILE_BITS; ++x) {
        if (tile(x, y) != null) return false;
      }
    }
    return true;
  }

  int cellAt(double coordinate_m) {
    return (int) Math.floor(coordinate_m / cell_size_m);
  }

  /** False, and nothing is changed, if the change is malformed or the map has no room for the tile. */
  boolean apply(MapPage.TileChange change) {
    if (!runsFit(change.runs)) return false;
    byte[] cells = tile(change.tile_x, change.tile_y);
    if (cells == null) {
      if (!makeRoomFor(change.tile_x, change.tile_y)) return false;
      cells = new byte[TILE_CELLS];
      Arrays.fill(cells, (byte) UNEXPLORED);
      tiles[(change.tile_y - low_y) * width + change.tile_x - low_x] = cells;
      ++num_tiles;
    }
    int cell = 0;
    for (int at = 0; at < change.runs.length;) {
      cell += twoBytes(change.runs, at);
      int count = twoBytes(change.runs, at + 2);
      System.arraycopy(change.runs, at + 4, cells, cell, count);
      at += 4 + count;
      cell += count;
    }
    return true;
  }

  /** Makes the rectangle as large as a new tile takes. False if that is beyond the limits. */
  private boolean makeRoomFor(int x, int y) {
    if (x < -MAX_TILE || x >= MAX_TILE || y < -MAX_TILE || y >= MAX_TILE || num_tiles == MOST_TILES) return false;
    int new_low_x = isEmpty() ? x : Math.min(low_x, x);
    int new_low_y = isEmpty() ? y : Math.min(low_y, y);
    int new_width = (isEmpty() ? x : Math.max(low_x + width - 1, x)) + 1 - new_low_x;
    int new_height = (isEmpty() ? y : Math.max(low_y + height - 1, y)) + 1 - new_low_y;
    if (new_width * new_height > MOST_TILES_IN_RECTANGLE) return false;
    byte[][] larger = new byte[new_width * new_height][];
    for (int row = 0; row < height; ++row) {
      int place = (low_y + row - new_low_y) * new_width + low_x - new_low_x;
      System.arraycopy(tiles, row * width, larger, place, width);
    }
    tiles = larger;
    low_x = new_low_x;
    low_y = new_low_y;
    width = new_width;
    height = new_height;
    return true;
  }

  /** Whether runs are well-formed and stay within a tile. */
  private static boolean runsFit(byte[] runs) {
    int cell = 0;
    for (int at = 0; at < runs.length;) {
      if (runs.length - at < 4) return false;
      int count = twoBytes(runs, at + 2);
      cell += twoBytes(runs, at) + count;
      at += 4;
      if (count == 0 || cell > TILE_CELLS || runs.length - at < count) return false;
      at += count;
    }
    return true;
  }

  private static int twoBytes(byte[] bytes, int at) {
    return (bytes[at] & 0xff) << 8 | bytes[at + 1] & 0xff;
  }
}
