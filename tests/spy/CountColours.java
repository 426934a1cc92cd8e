package crsm.spy;

import java.awt.Color;
import java.awt.image.BufferedImage;
import java.io.File;
import javax.imageio.ImageIO;

/** How many pixels of a screenshot have a colour of the map view. Argument: FILE.png. */
final class CountColours {
  private CountColours() {}

  public static void main(String[] arguments) throws Exception {
    BufferedImage image = ImageIO.read(new File(arguments[0]));
    count(image, "path", RobotPainter.PATH.getRGB());
    count(image, "start", RobotPainter.START.getRGB());
    count(image, "ray_on_wall", RobotPainter.RAY_ON_WALL.getRGB());
    count(image, "laser", new Color(190, 30, 30).getRGB());
    count(image, "unexplored", new Color(MapPainter.COLOUR[TileMap.UNEXPLORED]).getRGB());
    count(image, "free", Color.WHITE.getRGB());
    count(image, "occupied", Color.BLACK.getRGB());
  }

  private static void count(BufferedImage image, String name, int colour) {
    int num = 0;
    for (int y = 0; y < image.getHeight(); ++y) {
      for (int x = 0; x < image.getWidth(); ++x) num += image.getRGB(x, y) == colour ? 1 : 0;
    }
    System.out.println(name + " " + num);
  }
}
