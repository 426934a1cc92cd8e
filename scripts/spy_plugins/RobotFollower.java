package crsm.spy;

import crsm.map_request_t;
import java.io.IOException;
import java.util.concurrent.ThreadLocalRandom;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.regex.Pattern;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMEncodable;
import lcm.lcm.LCMSubscriber;

/**
 * Keeps a Robot up to date from a bus of its own, since lcm-spy keeps no more than the last message of a channel. Who
 * looks at the robot holds its lock: synchronized (follower.robot).
 */
class RobotFollower implements LCMSubscriber, AutoCloseable {
  private static final long POLL_NS = TimeUnit.MILLISECONDS.toNanos(20);
  private static final long FIRST_PAUSE_NS = TimeUnit.MILLISECONDS.toNanos(50);   // before a question is asked again
  private static final long LONGEST_PAUSE_NS = TimeUnit.SECONDS.toNanos(2);
  private static final long LEAST_REST_NS = TimeUnit.MILLISECONDS.toNanos(500);   // from a whole map to the next one
  private static final long LONGEST_REST_NS = TimeUnit.SECONDS.toNanos(3);
  private static final int REST_FACTOR = 5;  // of the time that the map took to come: large ones are asked for less

  final Robot robot = new Robot(drawRequester());
  private final LCM bus;
  private final String prefix;
  private final Thread asker;
  private volatile boolean closed = false;

  private map_request_t last_request;  // null while none waits for an answer
  private long pause_ns = FIRST_PAUSE_NS;
  private long next_request_ns;
  private long asked_since_ns = System.nanoTime();  // this version of the map
  private long next_doubt_ns;

  /** url: of the bus; null for LCM's default. prefix: of the robot's channels. */
  RobotFollower(String url, String prefix) throws IOException {
    this.prefix = prefix;
    bus = url == null ? new LCM() : new LCM(url);
    for (String channel : new String[] {"WHOLE_MAP", "SCAN_MATCH", "CRITICAL_RAYS"}) {
      bus.subscribe(Pattern.quote(prefix + channel), this);
    }
    asker = new Thread(this::askUntilClosed, "asks for the map");
    asker.setDaemon(true);
    asker.start();
  }

  private static long drawRequester() {
    return ThreadLocalRandom.current().nextLong(1, Long.MAX_VALUE);
  }

  @Override
  public void close() {
    closed = true;
  }

  /** Nothing may be thrown from here: it would end the thread that LCM receives with. */
  @Override
  public void messageReceived(LCM lcm, String channel, LCMDataInputStream input) {
    synchronized (robot) {
      try {
        byte[] message = new byte[input.available()];
        input.readFully(message);
        handle(channel.substring(prefix.length()), message);
      } catch (IOException malformed) {
        robot.countMalformed();
      }
    }
  }

  /** channel: without the prefix. */
  void handle(String channel, byte[] message) throws IOException {
    if (channel.equals("SCAN_MATCH")) {
      robot.add(ScanMatch.decode(message));
    } else if (channel.equals("CRITICAL_RAYS")) {
      robot.add(ScanRays.decode(message));
    } else {
      MapPage page = MapPage.decode(message, robot.replica.requester);
      if (page == null || robot.replica.isSynced()) return;
      robot.replica.handle(page);
      if (robot.replica.isSynced()) rest();
      LockSupport.unpark(asker);
    }
  }

  /** The map is whole: asks again after a while. */
  private void rest() {
    long now_ns = System.nanoTime();
    long rest_ns = REST_FACTOR * (now_ns - asked_since_ns);
    next_doubt_ns = now_ns + Math.max(LEAST_REST_NS, Math.min(rest_ns, LONGEST_REST_NS));
    last_request = null;
  }

  /** All is sent and closed here: LCM has a lock of its own for both, for which its receiving thread must not wait. */
  private void askUntilClosed() {
    while (!closed) {
      map_request_t request;
      synchronized (robot) {
        request = dueRequest();
      }
      if (request != null) publish(request);
      LockSupport.parkNanos(POLL_NS);
    }
    bus.close();
  }

  /** The request to send now, or null: the next page at once when one has come, else more and more seldom. */
  private map_request_t dueRequest() {
    long now_ns = System.nanoTime();
    if (robot.replica.isSynced() && now_ns - next_doubt_ns >= 0) {
      asked_since_ns = now_ns;
      robot.replica.doubt();
    }
    map_request_t request = robot.replica.nextRequest();
    if (request == null) return null;
    if (last_request == null || request.question != last_request.question) {
      pause_ns = FIRST_PAUSE_NS;
    } else if (now_ns - next_request_ns < 0) {
      return null;
    } else {
      pause_ns = Math.min(2 * pause_ns, LONGEST_PAUSE_NS);
    }
    next_request_ns = now_ns + pause_ns;
    last_request = request;
    return request;
  }

  void publish(LCMEncodable request) {
    bus.publish(prefix + "MAP_REQUEST", request);
  }

  /** How long the owner of the map has not answered [s]; 0 while the map is whole. */
  double unansweredS() {
    return robot.replica.isSynced() ? 0 : 1e-9 * (System.nanoTime() - asked_since_ns);
  }
}
