package crsm.spy;

import crsm.map_page_t;
import crsm.map_request_t;

/** One answer of the map's owner to a MAP_REQUEST: changed tiles, and matches. */
final class MapPage {
  private static final int MOST_TILES = 4096;
  private static final int MOST_MATCHES = 1024;
  private static final int MOST_LOOPS = 200;
  private static final int MOST_PIECES = 50;
  private static final int MOST_BREAKS = 200;
  private static final int MOST_DOUBTS = 1000;
  private static final int MOST_MARKS = 200;
  private static final int MOST_POINTS = 64;  // of a mark
  private static final int MOST_TEXT_BYTES = 64;
  private static final int MOST_REMEMBERED = 10;
  private static final int WHEEL_SUMS = 28;  // of wheel_model_t, and its two errors
  private static final int MOST_RUN_BYTES = TileMap.TILE_CELLS + 4;

  /** Changed cells of one tile, in runs as crsm_map_tile_t.lcm describes them. */
  static final class TileChange {
    int tile_x;
    int tile_y;
    byte[] runs;
  }

  map_request_t request;  // that it answers
  long epoch;
  long version;
  double cell_size_m;
  int next_tile;   // ask again from here; -1: there are no more
  int next_match;  // ask again from here
  TileChange[] tiles;
  ScanMatch[] matches;

  /** The fields in the order of crsm_map_page_t.lcm. Null for a page that is not for `recipient`: no more is read. */
  static MapPage decode(byte[] message, long recipient) throws MessageReader.Malformed {
    MessageReader reader = new MessageReader(message, map_page_t.LCM_FINGERPRINT);
    MapPage page = new MapPage();
    page.request = readRequest(reader);
    if (page.request.requester != recipient) return null;
    page.epoch = reader.readLong();
    MessageReader.require(page.epoch != 0, "no epoch");
    page.version = reader.readLong(0);
    page.cell_size_m = reader.readDouble(0.001, 10);
    page.next_tile = reader.readInt(-1, Integer.MAX_VALUE);
    page.next_match = reader.readInt(0, Integer.MAX_VALUE);
    page.tiles = readTiles(reader);
    page.matches = new ScanMatch[reader.readInt(0, MOST_MATCHES)];
    for (int i = 0; i < page.matches.length; ++i) page.matches[i] = ScanMatch.read(reader);
    if (reader.readInt(0, 1) == 1) skipTracking(reader);
    skipLoops(reader);
    skipLayout(reader);
    skipMarks(reader);
    reader.end();
    return page;
  }

  private static map_request_t readRequest(MessageReader reader) throws MessageReader.Malformed {
    map_request_t request = new map_request_t();
    request.requester = reader.readLong();
    request.question = reader.readLong(0);
    request.epoch = reader.readLong();
    request.base_version = reader.readLong(0);
    request.first_tile = reader.readInt(0, Integer.MAX_VALUE);
    request.first_match = reader.readInt(-1, Integer.MAX_VALUE);
    request.whole = reader.readByte();
    request.settled = reader.readByte();
    request.piece = reader.readInt(0, MOST_PIECES);
    return request;
  }

  /** What a matcher remembers: the fields in the order of crsm_tracking_state_t.lcm. */
  private static void skipTracking(MessageReader reader) throws MessageReader.Malformed {
    for (int i = 0; i < 2; ++i) reader.readLong(0);  // num_scans, num_lost
    reader.readLong(-1);  // newest_utime
    reader.readByte();  // on_finished_map
    int num_fitnesses = reader.readInt(0, MOST_REMEMBERED);
    for (int i = 0; i < num_fitnesses; ++i) reader.readDouble(0, 1);
    int num_recent = reader.readInt(0, MOST_REMEMBERED);
    for (int i = 0; i < num_recent; ++i) ScanMatch.read(reader);
    reader.skipPose();  // T_local_map
    reader.readByte();  // onset
    reader.skipPose();  // T_map_guess
    reader.readInt(0, Integer.MAX_VALUE - 1);  // trajectory
    reader.readByte();  // floating
    for (int i = 0; i < WHEEL_SUMS; ++i) reader.readDouble(-1e15, 1e15);
    for (int i = 0; i < 3; ++i) reader.readLong(0);  // steps, slips, steps_since_slip
    for (int i = 0; i < 2; ++i) reader.readByte();  // have_moved, has_start
    for (int pose = 0; pose < 2; ++pose) reader.skipPose();
    reader.readDouble(0, Double.MAX_VALUE);  // motion_error_m
  }

  /** The view does not draw them. */
  private static void skipLoops(MessageReader reader) throws MessageReader.Malformed {
    int num_loops = reader.readInt(0, MOST_LOOPS);
    for (int i = 0; i < num_loops; ++i) {
      for (int pose = 0; pose < 2; ++pose) reader.skipPose();
      reader.readByte();  // rejected
      reader.readByte();  // joins
    }
  }

  /** How the map hangs together, which the view does not show. */
  private static void skipLayout(MessageReader reader) throws MessageReader.Malformed {
    if (reader.readInt(0, 1) == 0) return;
    for (int i = 0; i < 7; ++i) reader.readLong(0);  // from num_all_pieces to num_rejected
    for (int i = 0; i < 3; ++i) reader.readDouble(-Double.MAX_VALUE, Double.MAX_VALUE);  // off_m, off_at_m
    int num_doubts = reader.readInt(0, MOST_DOUBTS);
    for (int i = 0; i < 3 * num_doubts; ++i) reader.readDouble(-Double.MAX_VALUE, Double.MAX_VALUE);
    for (int i = 0; i < 8; ++i) reader.readDouble(-Double.MAX_VALUE, Double.MAX_VALUE);  // way_back, slip
    int num_pieces = reader.readInt(0, MOST_PIECES);
    for (int i = 0; i < num_pieces; ++i) {
      reader.readLong(0);  // keyframes
      reader.readLong(0);  // scans
      reader.readDouble(0, Double.MAX_VALUE);  // way_m
    }
    int num_breaks = reader.readInt(0, MOST_BREAKS);
    for (int i = 0; i < num_breaks; ++i) {
      reader.readLong(0);  // utime
      reader.readLong(0);  // scan
      reader.readDouble(0, Double.MAX_VALUE);  // seconds
      reader.skipPose();
      reader.readInt(1, Integer.MAX_VALUE);  // piece_before
      reader.readInt(1, Integer.MAX_VALUE);  // piece
      reader.readByte();  // reason
    }
  }

  /** Places with names, which the view does not show. */
  private static void skipMarks(MessageReader reader) throws MessageReader.Malformed {
    int num_marks = reader.readInt(0, MOST_MARKS);
    for (int i = 0; i < num_marks; ++i) {
      reader.readLong(0);  // utime
      for (int text = 0; text < 3; ++text) reader.readBytes(reader.readInt(1, MOST_TEXT_BYTES));  // id, kind, name
      reader.readInt(1, Integer.MAX_VALUE);  // num_sightings
      for (int entry = 0; entry < 3; ++entry) reader.readDouble(-Double.MAX_VALUE, Double.MAX_VALUE);  // covariance
      reader.readByte();  // floating
      int num_points = reader.readInt(1, MOST_POINTS);
      for (int at = 0; at < 2 * num_points; ++at) reader.readDouble(-1e6, 1e6);
    }
  }

  private static TileChange[] readTiles(MessageReader reader) throws MessageReader.Malformed {
    TileChange[] tiles = new TileChange[reader.readInt(0, MOST_TILES)];
    for (int i = 0; i < tiles.length; ++i) {
      tiles[i] = new TileChange();
      tiles[i].tile_x = reader.readShort();
      tiles[i].tile_y = reader.readShort();
      tiles[i].runs = reader.readBytes(reader.readInt(0, MOST_RUN_BYTES));
    }
    return tiles;
  }
}
