package crsm.spy;

import java.util.LinkedHashMap;
import java.util.Map;

/** All that is known of one robot: its map and path, its last match, and the rays of that scan. */
final class Robot {
  private static final int MOST_SCANS = 32;  // whose matches may still come

  final MapReplica replica;
  private ScanMatch match;  // of the newest scan; null before the first
  private ScanRays rays;    // of the same scan; null where they did not come
  private final Map<Long, ScanRays> scans_by_utime = new LinkedHashMap<>();
  private long num_malformed = 0;

  Robot(long requester) {
    replica = new MapReplica(requester);
  }

  void add(ScanRays scan) {
    scans_by_utime.remove(scan.utime);
    scans_by_utime.put(scan.utime, scan);
    if (scans_by_utime.size() > MOST_SCANS) scans_by_utime.remove(scans_by_utime.keySet().iterator().next());
  }

  void add(ScanMatch newest) {
    match = newest;
    rays = scans_by_utime.get(newest.utime);
  }

  void countMalformed() {
    ++num_malformed;
  }

  ScanMatch match() {
    return match;
  }

  ScanRays rays() {
    return rays;
  }

  long numMalformed() {
    return num_malformed;
  }
}
