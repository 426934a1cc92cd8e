package crsm.spy;

import crsm.map_request_t;

/**
 * A copy of the whole map and of the path, kept whole over a network that loses messages: what map.png and
 * trajectory.tum have. It asks the map's owner page by page (MAP_REQUEST) for what has changed since the version that
 * it holds, and again for what did not come. When the owner has another map, or has put this one right (its epoch is
 * another one then), it begins anew, and shows what it held before until the new one is whole.
 *
 * It touches neither network nor clock: pages go in, and nextRequest says what to send.
 */
final class MapReplica {
  final long requester;  // a number of this replica's own, not 0

  private TileMap map = new TileMap(1);
  private RobotPath path = new RobotPath();
  private TileMap shown_map = map;
  private RobotPath shown_path = path;

  private map_request_t asked = new map_request_t();  // last
  private boolean synced = false;
  private long epoch = 0;  // of the map that is held; 0 before the owner was heard
  private long version = 0;
  private int num_matches = 0;
  private int next_tile = 0;         // of the pages under way
  private long pages_version = -1;   // the owner's when the first of them came; -1: none are under way
  private long num_pages = 0;
  private long num_refused_tiles = 0;

  MapReplica(long requester) {
    this.requester = requester;
  }

  /** Whether a whole version is held, so far as the replica knows. */
  boolean isSynced() {
    return synced;
  }

  long epoch() {
    return epoch;
  }

  long version() {
    return version;
  }

  /** Taken over so far: as long as it stays, map and path do. */
  long numPages() {
    return num_pages;
  }

  long numRefusedTiles() {
    return num_refused_tiles;
  }

  /** The last map that was whole; before there was one, what has come of the first. */
  TileMap map() {
    return shown_map;
  }

  RobotPath path() {
    return shown_path;
  }

  /** Doubts that the version held is the last: the owner is to be asked. */
  void doubt() {
    synced = false;
  }

  /** What to ask the owner; null when synced. A new question has a new number. */
  map_request_t nextRequest() {
    map_request_t request = question();
    if (request == null) return null;
    if (!isSame(request, asked)) ++request.question;
    asked = request;
    return request;
  }

  /** What the replica lacks, under the number of the last question; null when synced. */
  private map_request_t question() {
    if (synced) return null;
    map_request_t request = new map_request_t();
    request.requester = requester;
    request.question = asked.question;
    request.epoch = epoch;
    request.base_version = version;
    request.first_tile = next_tile;
    request.first_match = num_matches;
    request.whole = 1;
    return request;
  }

  private static boolean isSame(map_request_t one, map_request_t other) {
    return one.requester == other.requester && one.question == other.question && one.epoch == other.epoch &&
           one.base_version == other.base_version && one.first_tile == other.first_tile &&
           one.first_match == other.first_match && one.whole == other.whole &&
           one.settled == other.settled && one.piece == other.piece;
  }

  /** Takes a page that answers the last question, and no other: somebody else may have asked in this replica's name. */
  void handle(MapPage page) {
    map_request_t question = question();
    if (question == null || !isSame(page.request, question)) return;
    if (page.epoch != epoch) begin(page.epoch, page.cell_size_m);
    if (page.cell_size_m != map.cell_size_m) return;  // not the owner's: a map keeps its cells
    if (page.version < Math.max(num_matches, pages_version)) {  // the owner's journal has lost its end
      begin(epoch, page.cell_size_m);
      return;
    }
    if (page.next_match - page.matches.length != num_matches) return;
    if (pages_version < 0) pages_version = page.version;

    ++num_pages;
    // A page that comes twice does no harm: its tiles are whole.
    for (ScanMatch match : page.matches) path.add(match);
    num_matches += page.matches.length;
    for (MapPage.TileChange change : page.tiles) {
      if (!map.apply(change)) ++num_refused_tiles;
    }
    next_tile = page.next_tile >= 0 ? page.next_tile : Integer.MAX_VALUE;
    if (page.next_tile < 0 && page.next_match >= page.version) endRound(page.version);
  }

  /** All tiles were seen once. Those that changed meanwhile are asked for again, from where this round began. */
  private void endRound(long newest_version) {
    version = pages_version;
    pages_version = -1;
    next_tile = 0;
    synced = version == newest_version;
    if (!synced) return;
    shown_map = map;
    shown_path = path;
  }

  private void begin(long new_epoch, double cell_size_m) {
    boolean nothing_shown = shown_map == map && version == 0;
    epoch = new_epoch;
    version = 0;
    num_matches = 0;
    next_tile = 0;
    pages_version = -1;
    map = new TileMap(cell_size_m);
    path = new RobotPath();
    if (!nothing_shown) return;
    shown_map = map;
    shown_path = path;
  }
}
