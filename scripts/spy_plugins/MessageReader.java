package crsm.spy;

import java.io.IOException;
import java.nio.ByteBuffer;

/**
 * Reads an encoded message and trusts nothing in it. Decoders that lcm-gen makes allocate as much as a count says;
 * here every count and every value is held against its range first.
 */
final class MessageReader {
  /** The bytes are not those of the type, or a value is out of its range. */
  static final class Malformed extends IOException {
    Malformed(String what) {
      super(what);
    }
  }

  private static final double LARGEST_COORDINATE_M = 1e6;
  private static final double FULL_TURN_RAD = 2 * Math.PI + 1e-3;  // angles travel in single precision

  private final ByteBuffer bytes;  // in the order of the network

  /** fingerprint: of the type that the message must have. */
  MessageReader(byte[] message, long fingerprint) throws Malformed {
    bytes = ByteBuffer.wrap(message);
    require(readLong() == fingerprint, "another type");
  }

  static void require(boolean holds, String what) throws Malformed {
    if (!holds) throw new Malformed(what);
  }

  /** All of the message must have been read. */
  void end() throws Malformed {
    require(bytes.remaining() == 0, "bytes are left over");
  }

  private ByteBuffer need(int num_bytes) throws Malformed {
    require(num_bytes <= bytes.remaining(), "cut");
    return bytes;
  }

  byte readByte() throws Malformed {
    return need(1).get();
  }

  short readShort() throws Malformed {
    return need(2).getShort();
  }

  int readInt() throws Malformed {
    return need(4).getInt();
  }

  long readLong() throws Malformed {
    return need(8).getLong();
  }

  float readFloat() throws Malformed {
    return need(4).getFloat();
  }

  double readDouble() throws Malformed {
    return need(8).getDouble();
  }

  byte[] readBytes(int num_bytes) throws Malformed {
    byte[] read = new byte[num_bytes];
    need(num_bytes).get(read);
    return read;
  }

  int readInt(int least, int most) throws Malformed {
    int value = readInt();
    require(value >= least && value <= most, "a number is out of range");
    return value;
  }

  long readLong(long least) throws Malformed {
    long value = readLong();
    require(value >= least, "a number is out of range");
    return value;
  }

  double readDouble(double least, double most) throws Malformed {
    double value = readDouble();
    require(value >= least && value <= most, "a value is out of range");  // NaN is not >= least
    return value;
  }

  float readFloat(double least, double most) throws Malformed {
    float value = readFloat();
    require(value >= least && value <= most, "a value is out of range");
    return value;
  }

  double readCoordinateM() throws Malformed {
    return readDouble(-LARGEST_COORDINATE_M, LARGEST_COORDINATE_M);
  }

  void skipPose() throws Malformed {
    readCoordinateM();
    readCoordinateM();
    readAngleRad();
  }

  double readAngleRad() throws Malformed {
    return readDouble(-FULL_TURN_RAD, FULL_TURN_RAD);
  }
}
