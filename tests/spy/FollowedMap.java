package crsm.spy;

import java.awt.image.BufferedImage;
import java.io.BufferedReader;
import java.io.File;
import java.io.IOException;
import java.io.InputStreamReader;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Random;
import javax.imageio.ImageIO;

/**
 * Follows a robot on the bus as the view in lcm-spy does, but loses a share of all messages, and compares what it holds
 * with the results of a run. Reads lines: "settle" waits until the map changes no more; "compare FOLDER" says in how
 * many cells it is another one than map.png. Argument: the share.
 */
final class FollowedMap extends RobotFollower {
  private static final Random RANDOM = new Random(1);
  private static final int STILL_PAGES = 4;  // in which nothing was new
  private static final int MARGIN_CELLS = 30;  // around map.png, where nothing may be

  private final double loss;

  private FollowedMap(double loss) throws IOException {
    super(null, "");
    this.loss = loss;
  }

  public static void main(String[] arguments) throws Exception {
    FollowedMap followed = new FollowedMap(Double.parseDouble(arguments[0]));
    BufferedReader input = new BufferedReader(new InputStreamReader(System.in));
    for (String line = input.readLine(); line != null; line = input.readLine()) {
      String[] words = line.split(" ", 2);
      Robot robot = followed.robot;
      System.out.println(words[0].equals("settle") ? settle(robot) : compare(robot, Path.of(words[1])));
    }
    followed.close();
  }

  @Override
  void handle(String channel, byte[] message) throws IOException {
    if (RANDOM.nextDouble() >= loss) super.handle(channel, message);
  }

  @Override
  void publish(lcm.lcm.LCMEncodable request) {
    if (RANDOM.nextDouble() >= loss) super.publish(request);
  }

  /** Epoch and version of a map that is whole, and was asked for again and again since it changed; bad messages. */
  static String settle(Robot robot) throws InterruptedException {
    String last = "";
    long pages_then = 0;
    while (true) {
      synchronized (robot) {
        String now = robot.replica.epoch() + " " + robot.replica.version();
        if (!now.equals(last) || robot.replica.map().isEmpty()) pages_then = robot.replica.numPages();
        last = now;
        boolean asked_enough = robot.replica.numPages() >= pages_then + STILL_PAGES;
        if (asked_enough && robot.replica.isSynced()) return now + " " + robot.numMalformed();
      }
      Thread.sleep(10);
    }
  }

  static String compare(Robot robot, Path folder) throws IOException {
    BufferedImage expected = ImageIO.read(folder.resolve("map.png").toFile());
    String yaml = Files.readString(folder.resolve("map.yaml"));
    double cell_size_m = Double.parseDouble(yaml.split("resolution: ")[1].split("\n")[0]);
    String[] origin = yaml.split("origin: \\[")[1].split(",");
    int left = (int) Math.round(Double.parseDouble(origin[0]) / cell_size_m);
    int bottom = (int) Math.round(Double.parseDouble(origin[1]) / cell_size_m);
    BufferedImage held = new BufferedImage(expected.getWidth() + 2 * MARGIN_CELLS,
                                           expected.getHeight() + 2 * MARGIN_CELLS, BufferedImage.TYPE_INT_RGB);
    synchronized (robot) {
      Viewport view = new Viewport();
      view.showCells(cell_size_m, left - MARGIN_CELLS, bottom + expected.getHeight() - 1 + MARGIN_CELLS);
      MapPainter.paint(robot.replica.map(), view, held);
    }
    ImageIO.write(held, "png", new File(folder.toFile(), "held.png"));
    int num_explored = 0;
    int num_other = 0;
    for (int y = 0; y < held.getHeight(); ++y) {
      for (int x = 0; x < held.getWidth(); ++x) {
        int byte_of_map = at(expected, x - MARGIN_CELLS, y - MARGIN_CELLS);
        if (byte_of_map != TileMap.UNEXPLORED) ++num_explored;
        if ((held.getRGB(x, y) & 0xffffff) != MapPainter.COLOUR[byte_of_map]) ++num_other;
      }
    }
    return num_other + " of " + num_explored + " " + comparePath(robot, folder);
  }

  private static int at(BufferedImage map, int x, int y) {
    boolean inside = x >= 0 && x < map.getWidth() && y >= 0 && y < map.getHeight();
    return inside ? map.getRaster().getSample(x, y, 0) : TileMap.UNEXPLORED;
  }

  /** By how much the path is longer than that of trajectory.tum [m]. */
  private static double comparePath(Robot robot, Path folder) throws IOException {
    RobotPath expected = new RobotPath();
    for (String line : Files.readAllLines(folder.resolve("trajectory.tum"))) {
      if (line.startsWith("#")) continue;
      String[] words = line.split(" ");
      ScanMatch match = new ScanMatch();
      match.x_m = Double.parseDouble(words[1]);
      match.y_m = Double.parseDouble(words[2]);
      expected.add(match);
    }
    synchronized (robot) {
      return robot.replica.path().lengthM() - expected.lengthM();
    }
  }
}
