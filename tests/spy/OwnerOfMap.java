package crsm.spy;

import static crsm.spy.Tests.check;
import static crsm.spy.Tests.checkEqual;

import crsm.map_request_t;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;

/** Owns a map as map_updater does, and answers requests with small pages. */
final class OwnerOfMap {
  private static final int TILES_A_PAGE = 3;
  private static final int MATCHES_A_PAGE = 7;

  private static final class Tile {
    int x;
    int y;
    long changed_at;  // version
    final byte[] cells = new byte[TileMap.TILE_CELLS];
  }

  private final long epoch;
  private final double cell_size_m;
  private final Map<Integer, Tile> tiles = new LinkedHashMap<>();  // in the order of their creation
  private final List<ScanMatch> matches = new ArrayList<>();

  OwnerOfMap(long epoch, double cell_size_m) {
    this.epoch = epoch;
    this.cell_size_m = cell_size_m;
  }

  /** One more scan: a match, and a tile that changes. */
  void grow(Random random) {
    ScanMatch match = new ScanMatch();
    match.x_m = matches.size();
    match.state = (byte) random.nextInt(4);
    matches.add(match);
    int x = random.nextInt(6) - 3;
    int y = random.nextInt(6) - 3;
    Tile tile = tiles.computeIfAbsent(10 * x + y, key -> new Tile());
    tile.x = x;
    tile.y = y;
    tile.changed_at = matches.size();
    random.nextBytes(tile.cells);
  }

  MapPage answer(map_request_t request) {
    boolean same_map = request.epoch == epoch;
    MapPage page = new MapPage();
    page.request = request;
    page.epoch = epoch;
    page.version = matches.size();
    page.cell_size_m = cell_size_m;
    int first_match = Math.min(same_map ? request.first_match : 0, matches.size());
    page.next_match = Math.min(first_match + MATCHES_A_PAGE, matches.size());
    page.matches = matches.subList(first_match, page.next_match).toArray(new ScanMatch[0]);
    List<MapPage.TileChange> changes = new ArrayList<>();
    List<Tile> all = new ArrayList<>(tiles.values());
    int tile = same_map ? request.first_tile : 0;
    for (; tile < all.size() && changes.size() < TILES_A_PAGE; ++tile) {
      if (all.get(tile).changed_at > (same_map ? request.base_version : 0)) changes.add(pack(all.get(tile)));
    }
    page.next_tile = tile < all.size() ? tile : -1;
    page.tiles = changes.toArray(new MapPage.TileChange[0]);
    return page;
  }

  private static MapPage.TileChange pack(Tile tile) {
    MapPage.TileChange change = new MapPage.TileChange();
    change.tile_x = tile.x;
    change.tile_y = tile.y;
    change.runs = new byte[4 + TileMap.TILE_CELLS];
    change.runs[2] = TileMap.TILE_CELLS >> 8;
    System.arraycopy(tile.cells, 0, change.runs, 4, TileMap.TILE_CELLS);
    return change;
  }

  /** What the replica shows is this map, cell by cell, and this path. */
  void checkSame(MapReplica replica) {
    TileMap map = replica.map();
    checkEqual(map.cell_size_m, cell_size_m, "cell size");
    checkEqual(map.numTiles(), tiles.size(), "number of tiles");
    for (Tile tile : tiles.values()) {
      for (int cell = 0; cell < TileMap.TILE_CELLS; ++cell) {
        int value = map.at(64 * tile.x + cell % 64, 64 * tile.y + cell / 64);
        check(value == (tile.cells[cell] & 0xff), "a cell of tile " + tile.x + ", " + tile.y + " is another one");
      }
    }
    RobotPath path = new RobotPath();
    for (ScanMatch match : matches) path.add(match);
    checkEqual(replica.path().numPoints(), path.numPoints(), "points of the path");
    checkEqual(replica.path().lengthM(), path.lengthM(), "length of the path");
  }
}
