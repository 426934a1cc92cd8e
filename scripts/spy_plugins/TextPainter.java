package crsm.spy;

import java.awt.Color;
import java.awt.Font;
import java.awt.FontMetrics;
import java.awt.Graphics2D;
import java.awt.Point;
import java.awt.geom.Ellipse2D;
import java.awt.geom.RoundRectangle2D;
import java.util.ArrayList;
import java.util.List;
import java.util.Locale;

/** Says in words how a robot fares, and what the colours mean. */
final class TextPainter {
  private static final Font PLAIN = new Font(Font.SANS_SERIF, Font.PLAIN, 12);
  private static final Color PAPER = new Color(255, 255, 255, 225);
  private static final Color INK = new Color(40, 40, 40);
  private static final int LINE_PIXELS = 17;
  private static final int MARGIN_PIXELS = 10;
  private static final double SILENT_S = 3;  // as on map_viewer's page

  private final Graphics2D g;
  private final int width_pixels;
  private final int height_pixels;

  TextPainter(Graphics2D g, int width_pixels, int height_pixels) {
    this.g = g;
    this.width_pixels = width_pixels;
    this.height_pixels = height_pixels;
    g.setFont(PLAIN);
  }

  /** mouse: where it is; null: outside. */
  void paint(RobotFollower follower, Viewport view, Point mouse) {
    Robot robot = follower.robot;
    ScanMatch match = robot.match();
    List<String> lines = new ArrayList<>();
    lines.add(match == null ? "waiting for a pose" : describe(match, robot.matchAgeS()));
    if (match != null) lines.add(describePose(match));
    if (match != null && match.floating) {
      lines.add(say("floating: not joined to the map yet (trajectory %d)", match.trajectory));
    }
    if (robot.hasJustJoined()) lines.add(say("joined: trajectory %d is on the map now", match.trajectory));
    lines.addAll(describeMap(follower));
    if (mouse != null) lines.add(describeCell(robot.replica.map(), view.toXM(mouse.x), view.toYM(mouse.y)));
    paintCard(lines, match == null ? Color.GRAY : RobotPainter.colourOf(match));
    paintKey();
  }

  private static String say(String format, Object... values) {
    return String.format(Locale.ROOT, format, values);
  }

  private static String describe(ScanMatch match, double age_s) {
    if (age_s > SILENT_S) return say("no pose for %d s", (long) age_s);
    return say("%s    fitness %.3f    %d critical rays", match.describeState(), match.fitness, match.num_critical);
  }

  private static String describePose(ScanMatch match) {
    String pose = say("x %.2f m    y %.2f m    heading %.1f\u00b0", match.x_m, match.y_m, Math.toDegrees(match.yaw_rad));
    if (match.isUnknown()) return pose + "    nothing is known of the place";
    return pose + say("    \u00b1 along %d\u00b0 %.1f cm, across %.1f cm, heading %.2f\u00b0",
                      ScanMatch.toAxisDegrees(match.alongRad()), 100 * match.sigmaAlongM(), 100 * match.sigmaAcrossM(),
                      Math.toDegrees(Math.sqrt(match.covariance[5])));
  }

  private static List<String> describeMap(RobotFollower follower) {
    MapReplica replica = follower.robot.replica;
    List<String> lines = new ArrayList<>();
    if (replica.map().isEmpty()) {
      lines.add("no map has come yet");
    } else {
      lines.add(say("%d scans    %.0f m driven    cells of %s m", replica.version(), replica.path().lengthM(),
                    replica.map().cell_size_m));
    }
    if (follower.unansweredS() > SILENT_S) {
      lines.add(say("map_updater silent for %.0f s", follower.unansweredS()));
    }
    if (follower.robot.numMalformed() + replica.numRefusedTiles() > 0) {
      lines.add(say("%d malformed messages, %d refused tiles", follower.robot.numMalformed(),
                    replica.numRefusedTiles()));
    }
    return lines;
  }

  private static String describeCell(TileMap map, double x_m, double y_m) {
    int value = map.at(map.cellAt(x_m), map.cellAt(y_m));
    return say("mouse at x %.2f m    y %.2f m: %s", x_m, y_m,
               value == TileMap.UNEXPLORED ? "unexplored" : say("%d (0 occupied, 255 free)", value));
  }

  private void paintCard(List<String> lines, Color badge) {
    FontMetrics metrics = g.getFontMetrics();
    int width = 0;
    for (String line : lines) width = Math.max(width, metrics.stringWidth(line));
    int left = MARGIN_PIXELS;
    paintPaper(left, MARGIN_PIXELS, width + 40, lines.size() * LINE_PIXELS + 12);
    paintDot(left + 16, MARGIN_PIXELS + 15, 6, badge);
    g.setColor(INK);
    for (int i = 0; i < lines.size(); ++i) {
      g.drawString(lines.get(i), left + 30, MARGIN_PIXELS + 19 + i * LINE_PIXELS);
    }
  }

  private void paintKey() {
    Color[] colours = {RobotPainter.RAY_ON_WALL, RobotPainter.RAY_IN_UNEXPLORED, RobotPainter.RAY_ON_FREE,
                       RobotPainter.HIT, RobotPainter.PATH, RobotPainter.FLOATING, RobotPainter.START,
                       new Color(MapPainter.COLOUR[TileMap.UNEXPLORED])};
    String[] meanings = {"critical ray on a wall", "into the unexplored", "on free ground", "hit", "path", "floating",
                         "start", "unexplored"};
    FontMetrics metrics = g.getFontMetrics();
    int width = 10;
    for (String meaning : meanings) width += 28 + metrics.stringWidth(meaning);
    int top = height_pixels - MARGIN_PIXELS - LINE_PIXELS - 8;
    paintPaper(MARGIN_PIXELS, top, width, LINE_PIXELS + 8);
    int x = MARGIN_PIXELS + 16;
    for (int i = 0; i < meanings.length; ++i) {
      paintDot(x, top + 12, 5, colours[i]);
      g.setColor(INK);
      g.drawString(meanings[i], x + 9, top + 17);
      x += 28 + metrics.stringWidth(meanings[i]);
    }
  }

  private void paintPaper(int left, int top, int width, int height) {
    g.setColor(PAPER);
    g.fill(new RoundRectangle2D.Double(left, top, Math.min(width, width_pixels - 2 * MARGIN_PIXELS), height, 10, 10));
  }

  private void paintDot(double x, double y, double radius, Color colour) {
    g.setColor(colour);
    g.fill(new Ellipse2D.Double(x - radius, y - radius, 2 * radius, 2 * radius));
  }
}
