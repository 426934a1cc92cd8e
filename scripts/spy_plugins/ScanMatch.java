package crsm.spy;

import crsm.scan_match_t;

/** Where the laser stood when it took a scan, and how good that is. */
final class ScanMatch {
  private static final double FASTEST = 20;  // [m/s], [rad/s]
  private static final double UNKNOWN_M2 = 1e4;  // variance of a position of which nothing is known

  long utime;
  double x_m;
  double y_m;
  double yaw_rad;
  double fitness;
  int num_critical;
  final double[] covariance = new double[6];  // of x, y, yaw: xx, xy, x yaw, yy, y yaw, yaw yaw [m2, m rad, rad2]
  final double[] degenerate_axis = new double[2];  // unit vector x, y, map frame
  byte state;
  final double[] twist = new double[3];  // x, y, yaw: how the laser moved, in its own frame [m/s, m/s, rad/s]
  int trajectory;  // from 0
  boolean floating;  // the trajectory is not joined to the map that is shown

  static ScanMatch decode(byte[] message) throws MessageReader.Malformed {
    MessageReader reader = new MessageReader(message, scan_match_t.LCM_FINGERPRINT);
    ScanMatch match = read(reader);
    reader.end();
    return match;
  }

  /** The fields in the order of crsm_scan_match_t.lcm. */
  static ScanMatch read(MessageReader reader) throws MessageReader.Malformed {
    ScanMatch match = new ScanMatch();
    match.utime = reader.readLong(0);
    match.x_m = reader.readCoordinateM();
    match.y_m = reader.readCoordinateM();
    match.yaw_rad = reader.readAngleRad();
    match.fitness = reader.readDouble(0, 1);
    reader.readInt(0, Integer.MAX_VALUE);  // evaluations
    reader.readInt(0, Integer.MAX_VALUE);  // best_evaluation
    match.num_critical = reader.readInt(0, ScanRays.MOST_RAYS);
    reader.readLong(0);  // map_version
    for (int i = 0; i < 6; ++i) {
      boolean variance = i == 0 || i == 3 || i == 5;
      match.covariance[i] = reader.readDouble(variance ? 0 : -Double.MAX_VALUE, Double.MAX_VALUE);
    }
    for (int i = 0; i < 2; ++i) match.degenerate_axis[i] = reader.readDouble(-1, 1);
    match.state = reader.readByte();
    MessageReader.require(match.state >= scan_match_t.FIRST && match.state <= scan_match_t.DEGENERATE, "no such state");
    byte has_odometry = reader.readByte();
    MessageReader.require(has_odometry == 0 || has_odometry == 1, "has_odometry is neither 0 nor 1");
    reader.readCoordinateM();
    reader.readCoordinateM();
    reader.readAngleRad();
    for (int i = 0; i < 3; ++i) match.twist[i] = reader.readDouble(-FASTEST, FASTEST);
    match.trajectory = reader.readInt(0, Integer.MAX_VALUE - 1);
    byte floating = reader.readByte();
    MessageReader.require(floating == 0 || floating == 1, "floating is neither 0 nor 1");
    match.floating = floating == 1;
    int num_by_wheels = reader.readInt(0, 1);
    for (int i = 0; i < num_by_wheels; ++i) {
      reader.skipPose();
      for (int sigma = 0; sigma < 2; ++sigma) reader.readDouble(1e-6, 1e6);
    }
    return match;
  }

  boolean isLost() {
    return state == scan_match_t.LOST;
  }

  /** Nothing is known of the pose. */
  boolean isUnknown() {
    return covariance[0] >= UNKNOWN_M2;
  }

  /** As map_viewer's page says it. */
  String describeState() {
    if (state == scan_match_t.LOST) return num_critical == 0 ? "WITHOUT RAYS" : "LOST";
    if (floating) return "FLOATING";
    if (state == scan_match_t.DEGENERATE) {
      return "DEGENERATE along " + toAxisDegrees(Math.atan2(degenerate_axis[1], degenerate_axis[0])) + "\u00b0";
    }
    return state == scan_match_t.FIRST ? "START" : "OK";
  }

  /** Standard deviation in the direction in which the position is known worst [m]. */
  double sigmaAlongM() {
    return Math.sqrt(Math.max(0, 0.5 * (covariance[0] + covariance[3]) + spread()));
  }

  /** The same at right angles to it. */
  double sigmaAcrossM() {
    return Math.sqrt(Math.max(0, 0.5 * (covariance[0] + covariance[3]) - spread()));
  }

  /** Of the direction in which the position is known worst. */
  double alongRad() {
    return 0.5 * Math.atan2(2 * covariance[1], covariance[0] - covariance[3]);
  }

  private double spread() {
    return Math.hypot(0.5 * (covariance[0] - covariance[3]), covariance[1]);
  }

  /** 0 to 179: an axis has no sign. */
  static long toAxisDegrees(double angle_rad) {
    return (Math.round(Math.toDegrees(angle_rad)) + 180) % 180;
  }
}
