package crsm.spy;

import static crsm.spy.Tests.check;
import static crsm.spy.Tests.checkEqual;
import static crsm.spy.Tests.test;

import crsm.map_request_t;
import java.awt.geom.PathIterator;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;

/** The replica of the map against an owner that is asked over a network which loses, doubles and delays. */
final class ReplicaTest {
  private static final long REQUESTER = 42;
  private static final int MOST_UNDER_WAY = 20;

  private ReplicaTest() {}

  static void run() {
    test("a map comes whole through loss, doubles and delays while it grows", ReplicaTest::comesWhole);
    test("a map that grows while its pages travel is whole at their end", ReplicaTest::growsMeanwhile);
    test("a new map of the owner's takes the place of the old one, once it is whole", ReplicaTest::newMap);
    test("the way driven has no jump to another piece or trajectory, and no part of it floats", ReplicaTest::brokenPath);
    test("an owner whose journal has lost its end is followed", ReplicaTest::lostEnd);
    test("a map keeps its cells: a page with others is not the owner's", ReplicaTest::otherCells);
    test("answers to earlier questions are not heard, nor any when nothing was asked", ReplicaTest::unasked);
    test("answers to a question that somebody else asked in its name leave no hole", ReplicaTest::askedByAnother);
    test("a map has no more tiles than one may have, and no larger rectangle", ReplicaTest::limits);
    test("runs that leave their tile, or are cut, change nothing", ReplicaTest::badRuns);
    test("a path of a million poses takes no more memory than one of some thousands", ReplicaTest::longPath);
  }

  /** Asks and answers until the replica is whole. Each message is lost, doubled or late with some probability. */
  private static void converse(MapReplica replica, OwnerOfMap owner, Random random, double trouble) {
    List<MapPage> under_way = new ArrayList<>();
    replica.doubt();
    for (int round = 0; !replica.isSynced(); ++round) {
      check(round < 100_000, "it never becomes whole");
      if (random.nextDouble() < 0.1 * trouble) owner.grow(random);
      if (random.nextDouble() >= trouble) under_way.add(owner.answer(replica.nextRequest()));
      if (!under_way.isEmpty() && random.nextDouble() < trouble) under_way.add(under_way.get(0));
      if (under_way.size() > MOST_UNDER_WAY) under_way.clear();
      if (under_way.isEmpty() || random.nextDouble() < trouble) continue;
      MapPage page = under_way.remove(random.nextDouble() < trouble ? random.nextInt(under_way.size()) : 0);
      if (random.nextDouble() >= trouble) replica.handle(page);
    }
  }

  private static void comesWhole() {
    for (int seed = 0; seed < 300; ++seed) {
      Random random = new Random(seed);
      OwnerOfMap owner = new OwnerOfMap(1, 0.05);
      MapReplica replica = new MapReplica(REQUESTER);
      for (int time = 0; time < 5; ++time) {
        for (int i = 0; i < 20; ++i) owner.grow(random);
        converse(replica, owner, random, 0.3);
        converse(replica, owner, random, 0);  // late answers may have made it believe in an earlier version
        owner.checkSame(replica);
      }
    }
  }

  private static void growsMeanwhile() {
    Random random = new Random(1);
    OwnerOfMap owner = new OwnerOfMap(1, 0.05);
    for (int i = 0; i < 30; ++i) owner.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    replica.handle(owner.answer(replica.nextRequest()));
    for (int i = 0; i < 200; ++i) owner.grow(random);
    while (!replica.isSynced()) replica.handle(owner.answer(replica.nextRequest()));
    owner.checkSame(replica);
  }

  private static void newMap() {
    Random random = new Random(1);
    OwnerOfMap first = new OwnerOfMap(1, 0.05);
    OwnerOfMap second = new OwnerOfMap(2, 0.1);
    for (int i = 0; i < 50; ++i) first.grow(random);
    for (int i = 0; i < 80; ++i) second.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    converse(replica, first, random, 0.2);
    converse(replica, first, random, 0);
    replica.doubt();
    replica.handle(second.answer(replica.nextRequest()));
    check(!replica.isSynced(), "one page is taken for the whole map");
    first.checkSame(replica);  // is still shown
    converse(replica, second, random, 0.2);
    converse(replica, second, random, 0);
    second.checkSame(replica);
    checkEqual(replica.epoch(), 2L, "epoch");
  }

  private static void lostEnd() {
    Random random = new Random(1);
    OwnerOfMap whole = new OwnerOfMap(1, 0.05);
    OwnerOfMap cut = new OwnerOfMap(1, 0.05);
    for (int i = 0; i < 60; ++i) whole.grow(random);
    for (int i = 0; i < 40; ++i) cut.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    converse(replica, whole, random, 0);
    converse(replica, cut, random, 0);
    cut.checkSame(replica);
  }

  private static void otherCells() {
    Random random = new Random(1);
    OwnerOfMap owner = new OwnerOfMap(1, 0.05);
    OwnerOfMap forger = new OwnerOfMap(1, 0.06);
    for (int i = 0; i < 30; ++i) owner.grow(random);
    for (int i = 0; i < 90; ++i) forger.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    converse(replica, owner, random, 0);
    replica.doubt();
    for (int i = 0; i < 10; ++i) replica.handle(forger.answer(replica.nextRequest()));
    check(!replica.isSynced(), "the forger's map is taken");
    converse(replica, owner, random, 0);
    owner.checkSame(replica);
  }

  private static void unasked() {
    Random random = new Random(1);
    OwnerOfMap owner = new OwnerOfMap(1, 0.05);
    for (int i = 0; i < 30; ++i) owner.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    MapPage first = owner.answer(replica.nextRequest());
    converse(replica, owner, random, 0);
    long num_pages = replica.numPages();
    replica.handle(first);
    replica.handle(new OwnerOfMap(9, 0.05).answer(new MapReplica(REQUESTER).nextRequest()));
    checkEqual(replica.epoch(), 1L, "epoch");
    replica.doubt();
    replica.handle(first);
    checkEqual(replica.numPages(), num_pages, "pages taken");
    check(replica.nextRequest() != null, "it asks no more");
  }

  private static void askedByAnother() {
    Random random = new Random(1);
    OwnerOfMap owner = new OwnerOfMap(1, 0.05);
    for (int i = 0; i < 60; ++i) owner.grow(random);
    MapReplica replica = new MapReplica(REQUESTER);
    for (int i = 0; i < 1000 && !replica.isSynced(); ++i) {
      map_request_t forged = replica.nextRequest().copy();
      forged.first_tile = Integer.MAX_VALUE;
      replica.handle(owner.answer(forged));
      replica.handle(owner.answer(replica.nextRequest()));
    }
    owner.checkSame(replica);
  }

  private static MapPage.TileChange change(int x, int y, int... runs) {
    MapPage.TileChange change = new MapPage.TileChange();
    change.tile_x = x;
    change.tile_y = y;
    change.runs = Tests.tile(x, y, runs).runs;
    return change;
  }

  private static void limits() {
    TileMap map = new TileMap(0.05);
    check(map.apply(change(-1024, -1024, 0, 0, 0, 1, 9)), "the lower left tile is refused");
    check(!map.apply(change(1023, 1023, 0, 0, 0, 1, 9)), "the largest rectangle there is is taken");
    check(!map.apply(change(-1025, -1024, 0, 0, 0, 1, 9)), "a tile beyond the limits is taken");
    checkEqual(map.at(-1024 * 64, -1024 * 64), 9, "the lower left cell");
    checkEqual(map.at(1023 * 64, 1023 * 64), TileMap.UNEXPLORED, "a cell of a refused tile");
    map = new TileMap(0.05);
    int num_taken = 0;
    for (int i = 0; i < 20_000; ++i) num_taken += map.apply(change(i % 200, i / 200, 0, 0, 0, 1, 9)) ? 1 : 0;
    checkEqual(num_taken, TileMap.MOST_TILES, "tiles taken");
  }

  private static void badRuns() {
    TileMap map = new TileMap(0.05);
    int[][] all_runs = {{0}, {0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 2, 9}, {0x10, 0, 0, 1, 9}, {0xff, 0xff, 0xff, 0xff, 9},
                        {0, 0, 0, 1, 9, 0x0f, 0xff, 0, 1, 9}};
    for (int[] runs : all_runs) check(!map.apply(change(0, 0, runs)), "taken: " + java.util.Arrays.toString(runs));
    check(map.isEmpty(), "something was changed");
    check(map.apply(change(0, 0, 0x0f, 0xff, 0, 1, 9)), "the last cell of a tile is refused");
    checkEqual(map.at(63, 63), 9, "the last cell");
  }

  private static void brokenPath() {
    RobotPath path = new RobotPath();
    for (int i = 0; i < 30; ++i) {
      ScanMatch match = new ScanMatch();
      match.trajectory = i / 10;
      match.floating = match.trajectory == 1;
      match.x_m = i + 100 * match.trajectory;
      path.add(match);
    }
    checkEqual(path.lengthM(), 18.0, "its length");
  }

  private static void longPath() {
    RobotPath path = new RobotPath();
    ScanMatch match = new ScanMatch();
    for (int i = 0; i < 1_000_000; ++i) {
      match.x_m = 0.02 * i;
      path.add(match);
    }
    check(path.numPoints() <= 1 << 14, path.numPoints() + " points");
    check(path.numPoints() >= 1 << 12, "only " + path.numPoints() + " points");
    check(Math.abs(path.lengthM() - match.x_m) < 1e-3 * match.x_m, "its length is " + path.lengthM());
    checkEqual(path.startXM(), 0.0, "start");
    double[] point = new double[6];
    double last_m = Double.NaN;
    for (PathIterator at = path.outline(false).getPathIterator(null); !at.isDone(); at.next()) {
      at.currentSegment(point);
      check(!(point[0] - last_m > 4 * match.x_m / path.numPoints()), "a gap at " + last_m + " m");
      check(!(point[0] - last_m < 0.25 * match.x_m / path.numPoints()), "points too near at " + last_m + " m");
      last_m = point[0];
    }
  }
}
