package crsm.spy;

import crsm.critical_rays_t;
import crsm.map_page_t;
import crsm.map_break_t;
import crsm.map_doubt_t;
import crsm.map_loop_t;
import crsm.map_piece_t;
import crsm.map_pieces_t;
import crsm.map_request_t;
import crsm.map_tile_t;
import crsm.placed_mark_t;
import crsm.pose2_t;
import crsm.scan_match_t;
import crsm.tracking_state_t;
import crsm.wheel_model_t;
import crsm.wheel_motion_t;
import java.io.IOException;
import java.util.Arrays;
import java.util.Random;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;

/** What the tests share: a sentence for each, and messages as the services send them. */
final class Tests {
  interface Test {
    void run() throws Exception;
  }

  private static int num_failed = 0;

  private Tests() {}

  public static void main(String[] arguments) {
    WireTest.run();
    ReplicaTest.run();
    ViewTest.run();
    System.exit(num_failed == 0 ? 0 : 1);
  }

  static void test(String sentence, Test test) {
    try {
      test.run();
      System.out.println("ok      " + sentence);
    } catch (Throwable failure) {  // of what a hostile message might bring about, errors too
      ++num_failed;
      System.out.println("FAILED  " + sentence);
      failure.printStackTrace(System.out);
    }
  }

  static void check(boolean holds, String what) {
    if (!holds) throw new AssertionError(what);
  }

  static void checkEqual(Object is, Object expected, String what) {
    check(is.equals(expected), what + " is " + is + ", not " + expected);
  }

  static byte[] encode(LCMEncodable message) throws IOException {
    LCMDataOutputStream output = new LCMDataOutputStream();
    message.encode(output);
    return output.toByteArray();
  }

  static scan_match_t match(long utime, double x_m, double y_m) {
    scan_match_t match = new scan_match_t();
    match.utime = utime;
    match.x_m = x_m;
    match.y_m = y_m;
    match.yaw_rad = -0.5;
    match.fitness = 0.75;
    match.evaluations = 1000;
    match.best_evaluation = 999;
    match.num_critical = 40;
    match.map_version = 7;
    match.covariance = new double[] {0.01, -0.002, 0.003, 0.04, 0.005, 0.06};
    match.degenerate_axis = new double[] {0.6, 0.8};
    match.state = scan_match_t.DEGENERATE;
    match.has_odometry = 1;
    match.odometry_x_m = 1;
    match.twist_x_m_s = 0.5;
    match.twist_yaw_rad_s = -3;
    match.trajectory = 3;
    match.floating = 1;
    match.num_by_wheels = 1;
    match.by_wheels = new wheel_motion_t[] {new wheel_motion_t()};
    match.by_wheels[0].T_from_to = new pose2_t();
    match.by_wheels[0].sigma_m = match.by_wheels[0].sigma_rad = 0.02;
    return match;
  }

  static map_tile_t tile(int x, int y, int... runs) {
    map_tile_t tile = new map_tile_t();
    tile.tile_x = (short) x;
    tile.tile_y = (short) y;
    tile.num_bytes = runs.length;
    tile.runs = new byte[runs.length];
    for (int i = 0; i < runs.length; ++i) tile.runs[i] = (byte) runs[i];
    return tile;
  }

  static map_loop_t loop(double x_m, int rejected) {
    map_loop_t loop = new map_loop_t();
    loop.T_map_older = new pose2_t();
    loop.T_map_newer = new pose2_t();
    loop.T_map_newer.x_m = x_m;
    loop.rejected = (byte) rejected;
    return loop;
  }

  static placed_mark_t mark() {
    placed_mark_t mark = new placed_mark_t();
    mark.id = "v1";
    mark.kind = "victim";
    mark.name = "";
    mark.num_sightings = 1;
    mark.covariance = new double[] {0.25, 0, 0.25};
    mark.num_points = 1;
    mark.x_m = new double[] {1.5};
    mark.y_m = new double[] {-2.5};
    return mark;
  }

  static map_pieces_t layout() {
    map_pieces_t layout = new map_pieces_t();
    layout.num_all_pieces = layout.num_pieces = 1;
    layout.pieces = new map_piece_t[] {new map_piece_t()};
    layout.num_all_breaks = layout.num_breaks = 1;
    layout.breaks = new map_break_t[] {new map_break_t()};
    layout.breaks[0].T_map_before = new pose2_t();
    layout.num_doubts = 1;
    layout.doubts = new map_doubt_t[] {new map_doubt_t()};
    layout.breaks[0].piece_before = layout.breaks[0].piece = 1;
    return layout;
  }

  static tracking_state_t tracking(scan_match_t[] matches) {
    tracking_state_t tracking = new tracking_state_t();
    tracking.num_scans = matches.length;
    tracking.num_fitnesses = 1;
    tracking.fitness = new double[] {0.5};
    tracking.num_recent = Math.min(matches.length, 1);
    tracking.recent = Arrays.copyOf(matches, tracking.num_recent);
    tracking.T_local_map = new pose2_t();
    tracking.T_map_guess = new pose2_t();
    tracking.wheels = new wheel_model_t();
    tracking.wheels.T_map_start = new pose2_t();
    tracking.wheels.T_odom_start = new pose2_t();
    return tracking;
  }

  static map_request_t request(long requester) {
    map_request_t request = new map_request_t();
    request.requester = requester;
    request.question = 1;
    request.whole = 1;
    return request;
  }

  /** A page with these tiles and matches, and two loops, and a piece with a break; the first and last of version 1. */
  static map_page_t page(long recipient, map_tile_t[] tiles, scan_match_t[] matches) {
    map_page_t page = new map_page_t();
    page.epoch = 11;
    page.version = 1;
    page.cell_size_m = 0.05;
    page.request = request(recipient);
    page.next_tile = -1;
    page.next_match = matches.length;
    page.num_tiles = tiles.length;
    page.tiles = tiles;
    page.num_matches = matches.length;
    page.matches = matches;
    page.num_tracking = 1;
    page.tracking = new tracking_state_t[] {tracking(matches)};
    page.num_loops = 2;
    page.loops = new map_loop_t[] {loop(1, 0), loop(2, 1)};
    page.num_layouts = 1;
    page.layout = new map_pieces_t[] {layout()};
    page.num_marks = 1;
    page.marks = new placed_mark_t[] {mark()};
    return page;
  }

  static critical_rays_t rays(int num_rays, Random random) {
    critical_rays_t scan = new critical_rays_t();
    scan.utime = 5;
    scan.num_rays = num_rays;
    scan.angle_rad = new float[num_rays];
    scan.range_m = new float[num_rays];
    for (int i = 0; i < num_rays; ++i) {
      scan.angle_rad[i] = 0.001f * i;
      scan.range_m[i] = 0.1f + random.nextFloat();
    }
    scan.num_critical = 2;
    scan.critical = new short[] {1, (short) (num_rays - 1)};
    scan.num_times = num_rays;
    scan.time_s = new float[num_rays];
    for (int i = 0; i < num_rays; ++i) scan.time_s[i] = -0.1f + 0.1f * i / num_rays;
    return scan;
  }
}
