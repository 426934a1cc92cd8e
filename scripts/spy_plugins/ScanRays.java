package crsm.spy;

import crsm.critical_rays_t;

/** The valid rays of a scan, and which of them are critical. */
final class ScanRays {
  static final int MOST_RAYS = 4096;
  private static final double LONGEST_RANGE_M = 1000;
  private static final double LONGEST_SWEEP_S = 2;
  private static final double TWO_TURNS_RAD = 4 * Math.PI + 2e-3;

  long utime;
  float[] angle_rad;  // laser frame
  float[] range_m;
  boolean[] is_critical;
  float[] time_s;  // after utime

  /** The fields in the order of crsm_critical_rays_t.lcm. */
  static ScanRays decode(byte[] message) throws MessageReader.Malformed {
    MessageReader reader = new MessageReader(message, critical_rays_t.LCM_FINGERPRINT);
    ScanRays scan = new ScanRays();
    scan.utime = reader.readLong(0);
    int num_rays = reader.readInt(0, MOST_RAYS);
    scan.angle_rad = new float[num_rays];
    scan.range_m = new float[num_rays];
    scan.is_critical = new boolean[num_rays];
    for (int i = 0; i < num_rays; ++i) scan.angle_rad[i] = reader.readFloat(-TWO_TURNS_RAD, TWO_TURNS_RAD);
    for (int i = 0; i < num_rays; ++i) scan.range_m[i] = reader.readFloat(Float.MIN_VALUE, LONGEST_RANGE_M);
    int num_critical = reader.readInt(0, num_rays);
    for (int i = 0; i < num_critical; ++i) {
      int ray = reader.readShort();
      MessageReader.require(ray >= 0 && ray < num_rays, "a critical ray is none of the rays");
      scan.is_critical[ray] = true;
    }
    int num_times = reader.readInt(0, num_rays);
    MessageReader.require(num_times == 0 || num_times == num_rays, "some rays have times, and others none");
    scan.time_s = new float[num_rays];
    for (int i = 0; i < num_times; ++i) scan.time_s[i] = reader.readFloat(-LONGEST_SWEEP_S, LONGEST_SWEEP_S);
    reader.end();
    return scan;
  }
}
