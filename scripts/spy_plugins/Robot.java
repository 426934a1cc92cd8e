package crsm.spy;

import java.util.LinkedHashMap;
import java.util.Map;

/** All that is known of one robot: its map and path, its last match, and the rays of that scan. */
final class Robot {
  private static final int MOST_SCANS = 32;  // whose matches may still come
  private static final long JUST_NS = 8_000_000_000L;

  final MapReplica replica;
  private ScanMatch match;  // of the newest scan; null before the first
  private long matched_ns;  // when that came
  private ScanRays rays;    // of the same scan; null where they did not come
  private final Map<Long, ScanRays> scans_by_utime = new LinkedHashMap<>();
  private long num_malformed = 0;
  private long joined_ns;  // when the trajectory that floated before was on the map
  private boolean has_joined = false;

  Robot(long requester) {
    replica = new MapReplica(requester);
  }

  void add(ScanRays scan) {
    scans_by_utime.remove(scan.utime);
    scans_by_utime.put(scan.utime, scan);
    if (scans_by_utime.size() > MOST_SCANS) scans_by_utime.remove(scans_by_utime.keySet().iterator().next());
  }

  void add(ScanMatch newest) {
    boolean goes_on = match != null && match.trajectory == newest.trajectory;
    if (goes_on && match.floating && !newest.floating) {
      joined_ns = System.nanoTime();
      has_joined = true;
    } else if (!goes_on || newest.floating) {
      has_joined = false;
    }
    match = newest;
    matched_ns = System.nanoTime();
    rays = scans_by_utime.get(newest.utime);
  }

  void countMalformed() {
    ++num_malformed;
  }

  ScanMatch match() {
    return match;
  }

  /** Since the last match came. */
  double matchAgeS() {
    return 1e-9 * (System.nanoTime() - matched_ns);
  }

  /** Whether its trajectory floated until a few seconds ago, and is on the map since. */
  boolean hasJustJoined() {
    return has_joined && System.nanoTime() - joined_ns < JUST_NS;
  }

  ScanRays rays() {
    return rays;
  }

  long numMalformed() {
    return num_malformed;
  }
}
