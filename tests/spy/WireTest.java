package crsm.spy;

import static crsm.spy.Tests.check;
import static crsm.spy.Tests.checkEqual;
import static crsm.spy.Tests.encode;
import static crsm.spy.Tests.match;
import static crsm.spy.Tests.page;
import static crsm.spy.Tests.rays;
import static crsm.spy.Tests.test;
import static crsm.spy.Tests.tile;

import crsm.critical_rays_t;
import crsm.map_page_t;
import crsm.map_tile_t;
import crsm.scan_match_t;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.Random;

/** What is read of messages, against what lcm-gen's encoders write. */
final class WireTest {
  private static final long RECIPIENT = 42;

  private WireTest() {}

  private interface Decoder {
    Object decode(byte[] message) throws MessageReader.Malformed;
  }

  private static final Decoder[] DECODERS = {message -> MapPage.decode(message, RECIPIENT), ScanMatch::decode,
                                             ScanRays::decode};

  private static byte[] encodePage() throws Exception {
    return encode(page(RECIPIENT, new map_tile_t[] {tile(-3, 4, 0, 1, 0, 2, 255, 0), tile(1, 1, 0, 0, 0, 1, 9)},
                       new scan_match_t[] {match(1, 2, 3), match(2, 3, 4)}));
  }

  private static byte[][] messages() throws Exception {
    return new byte[][] {encodePage(), encode(match(9, 1, 2)), encode(rays(50, new Random(1)))};
  }

  static void run() {
    test("a match is read as it was written", WireTest::readMatch);
    test("the rays of a scan are read as they were written", WireTest::readRays);
    test("a page of the map is read as it was written", WireTest::readPage);
    test("a page for another one is not read", () -> check(MapPage.decode(encodePage(), 43) == null, "it was read"));
    test("a message that is cut anywhere, or too long, is malformed", WireTest::refuseCut);
    test("a message of another type is malformed", WireTest::refuseOtherType);
    test("a count that is hostile is malformed, and takes no memory", WireTest::refuseCounts);
    test("a match is described by the words of the page", WireTest::describeMatch);
    test("values that are not finite or out of range are malformed", WireTest::refuseValues);
    test("of 300,000 messages with wrong bytes none does harm", WireTest::surviveWrongBytes);
  }

  private static void readMatch() throws Exception {
    scan_match_t written = match(9, 1.5, -2.5);
    ScanMatch read = ScanMatch.decode(encode(written));
    checkEqual(read.utime, 9L, "utime");
    checkEqual(read.x_m, 1.5, "x");
    checkEqual(read.y_m, -2.5, "y");
    checkEqual(read.yaw_rad, -0.5, "yaw");
    checkEqual(read.fitness, 0.75, "fitness");
    checkEqual(read.num_critical, 40, "num_critical");
    check(Arrays.equals(read.covariance, written.covariance), "covariance");
    check(Arrays.equals(read.degenerate_axis, written.degenerate_axis), "axis");
    checkEqual(read.state, scan_match_t.DEGENERATE, "state");
    check(Arrays.equals(read.twist, new double[] {0.5, 0, -3}), "twist");
    checkEqual(read.trajectory, 3, "trajectory");
    checkEqual(read.floating, true, "floating");
  }

  private static void describeMatch() {
    ScanMatch match = new ScanMatch();
    match.state = scan_match_t.FIRST;
    checkEqual(match.describeState(), "START", "first");
    match.state = scan_match_t.OK;
    checkEqual(match.describeState(), "OK", "matched");
    match.floating = true;
    checkEqual(match.describeState(), "FLOATING", "floats");
    match.state = scan_match_t.LOST;
    checkEqual(match.describeState(), "WITHOUT RAYS", "nothing of it was a measurement");
    match.num_critical = 40;
    checkEqual(match.describeState(), "LOST", "lost");
    match.floating = false;
    match.state = scan_match_t.DEGENERATE;
    match.degenerate_axis[0] = match.degenerate_axis[1] = -Math.sqrt(0.5);
    checkEqual(match.describeState(), "DEGENERATE along 45\u00b0", "degenerate");
    double[] covariance = {4e-4, 0, 0, 9e-4, 0, 0};
    System.arraycopy(covariance, 0, match.covariance, 0, 6);
    check(Math.abs(match.sigmaAlongM() - 0.03) < 1e-12 && Math.abs(match.sigmaAcrossM() - 0.02) < 1e-12, "sigmas");
    checkEqual(ScanMatch.toAxisDegrees(match.alongRad()), 90L, "the direction of the larger one");
  }

  private static void readRays() throws Exception {
    critical_rays_t written = rays(ScanRays.MOST_RAYS, new Random(2));
    ScanRays read = ScanRays.decode(encode(written));
    checkEqual(read.utime, 5L, "utime");
    check(Arrays.equals(read.angle_rad, written.angle_rad), "angles");
    check(Arrays.equals(read.range_m, written.range_m), "ranges");
    check(Arrays.equals(read.time_s, written.time_s), "times");
    for (int i = 0; i < written.num_rays; ++i) {
      checkEqual(read.is_critical[i], i == 1 || i == written.num_rays - 1, "ray " + i);
    }
  }

  private static void readPage() throws Exception {
    MapPage read = MapPage.decode(encodePage(), RECIPIENT);
    checkEqual(read.epoch, 11L, "epoch");
    checkEqual(read.version, 1L, "version");
    checkEqual(read.cell_size_m, 0.05, "cell_size_m");
    checkEqual(read.next_tile, -1, "next_tile");
    checkEqual(read.next_match, 2, "next_match");
    checkEqual(read.matches[1].x_m, 3.0, "x of the second match");
    checkEqual(read.tiles[0].tile_x + 10 * read.tiles[0].tile_y, 37, "tile");
    check(Arrays.equals(read.tiles[1].runs, new byte[] {0, 0, 0, 1, 9}), "runs");
  }

  private static boolean isRefused(Decoder decoder, byte[] message) {
    try {
      return decoder.decode(message) == null;
    } catch (MessageReader.Malformed malformed) {
      return true;
    }
  }

  private static void refuseCut() throws Exception {
    for (int type = 0; type < DECODERS.length; ++type) {
      byte[] message = messages()[type];
      check(!isRefused(DECODERS[type], message), "the whole message is refused, type " + type);
      for (int size = 0; size <= message.length + 1; ++size) {
        if (size == message.length) continue;
        check(isRefused(DECODERS[type], Arrays.copyOf(message, size)), size + " bytes are taken, type " + type);
      }
    }
  }

  private static void refuseOtherType() throws Exception {
    for (int type = 0; type < DECODERS.length; ++type) {
      check(isRefused(DECODERS[type], messages()[(type + 1) % DECODERS.length]), "taken as type " + type);
    }
  }

  /** The heap of the tests is 128 MB: what a decoder of lcm-gen's would allocate is not there. */
  private static void refuseCounts() throws Exception {
    for (int type = 0; type < DECODERS.length; ++type) {
      for (int count : new int[] {-1, Integer.MIN_VALUE, Integer.MAX_VALUE, 1 << 30, 1 << 24, 100_000}) {
        for (int at = 8; at + 4 <= messages()[type].length; ++at) {
          byte[] message = messages()[type];
          ByteBuffer.wrap(message).putInt(at, count);
          isRefused(DECODERS[type], message);
        }
      }
    }
    byte[] rays = messages()[2];
    ByteBuffer.wrap(rays).putInt(16, 51);  // num_rays
    check(isRefused(ScanRays::decode, rays), "one ray more than there are is taken");
  }

  private static void refuseValues() throws Exception {
    for (double x_m : new double[] {Double.NaN, Double.POSITIVE_INFINITY, 1e7}) {
      check(isRefused(ScanMatch::decode, encode(match(1, x_m, 0))), "x of " + x_m);
    }
    scan_match_t stateless = match(1, 0, 0);
    stateless.state = 4;
    check(isRefused(ScanMatch::decode, encode(stateless)), "state 4");
    critical_rays_t scan = rays(9, new Random(1));
    scan.critical[0] = 9;
    check(isRefused(ScanRays::decode, encode(scan)), "the tenth ray of nine");
    scan = rays(9, new Random(1));
    scan.num_times = 8;
    check(isRefused(ScanRays::decode, encode(scan)), "times of eight rays of nine");
    scan_match_t fast = match(1, 0, 0);
    fast.twist_yaw_rad_s = 21;
    check(isRefused(ScanMatch::decode, encode(fast)), "a turn of 21 rad/s");
    for (double cell_size_m : new double[] {0, -1, Double.NaN, 1e-9, 11}) {
      map_page_t page = page(RECIPIENT, new map_tile_t[0], new scan_match_t[0]);
      page.cell_size_m = cell_size_m;
      check(isRefused(DECODERS[0], encode(page)), "cells of " + cell_size_m);
    }
    map_page_t page = page(RECIPIENT, new map_tile_t[0], new scan_match_t[0]);
    page.epoch = 0;
    check(isRefused(DECODERS[0], encode(page)), "epoch 0");
  }

  private static void surviveWrongBytes() throws Exception {
    Random random = new Random(7);
    MapReplica replica = new MapReplica(RECIPIENT);
    int num_taken = 0;
    for (int i = 0; i < 300_000; ++i) {
      int type = i % DECODERS.length;
      byte[] message = messages()[type];
      for (int change = random.nextInt(4); change >= 0; --change) {
        message[8 + random.nextInt(message.length - 8)] = (byte) random.nextInt();
      }
      if (isRefused(DECODERS[type], message)) continue;
      ++num_taken;
      if (type == 0) replica.handle(MapPage.decode(message, RECIPIENT));
      replica.doubt();
    }
    check(num_taken > 10_000, "only " + num_taken + " were taken: the test does not get beyond the decoders");
  }
}
