package crsm.spy;

import java.awt.*;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import java.io.File;
import java.util.HashMap;
import java.util.Map;
import javax.imageio.ImageIO;
import javax.swing.*;

/**
 * Runs lcm-spy for some seconds, opens the views of the first laser and of the first map as a user would, and writes
 * all windows to a PNG. Fails when no channel came or one could not be decoded. Arguments: FILE.png SECONDS.
 */
public class SpyScreenshot {
  private static final int COLUMN_WIDTH = 900;
  private static final int COLUMN_HEIGHT = 800;
  private static final int TABLE_HEIGHT = 350;

  public static void main(String[] arguments) {
    boolean good = false;
    try {
      good = take(new File(arguments[0]), Integer.parseInt(arguments[1]));
    } catch (Exception failure) {
      failure.printStackTrace();
    }
    System.exit(good ? 0 : 1);  // what the windows run on would go on
  }

  private static boolean take(File file, int seconds) throws Exception {
    lcm.spy.Spy.main(new String[0]);
    Frame.getFrames()[0].setSize(COLUMN_WIDTH, TABLE_HEIGHT);
    Thread.sleep(1000L * seconds);
    boolean[] good = new boolean[1];
    SwingUtilities.invokeAndWait(() -> good[0] = readTable(findTable(Frame.getFrames()[0])));
    Thread.sleep(2000);  // for the views that it opened to draw a sweep and the map
    BufferedImage[] image = new BufferedImage[1];
    SwingUtilities.invokeAndWait(() -> image[0] = paintWindows());
    ImageIO.write(image[0], "png", file);
    return good[0];
  }

  /** Prints the table of channels, opens a view of each type that is to be seen. True if all is well. */
  private static boolean readTable(JTable table) {
    boolean good = table.getRowCount() > 0;
    if (!good) System.err.println("no message came on any channel");
    Map<String, Integer> heights = new HashMap<>();  // of the views that are to be opened, by type
    heights.put("planar_lidar_t", COLUMN_HEIGHT - TABLE_HEIGHT);
    heights.put("map_delta_t", COLUMN_HEIGHT);
    for (int row = 0; row < table.getRowCount(); ++row) {
      Object type = cell(table, row, "Type");
      System.out.printf("%-20s %-20s %6s messages, %s undecodable%n", cell(table, row, "Channel"), type,
                        cell(table, row, "Num Msgs"), cell(table, row, "Undecodable"));
      if (cell(table, row, "Channel").equals("LCM_SELF_TEST")) continue;  // no message: each program greets itself so
      good &= !type.toString().startsWith("??") && "0".equals(cell(table, row, "Undecodable").toString());
      Integer height = heights.remove(type);
      if (height == null) continue;
      doubleClick(table, row);
      Frame[] frames = Frame.getFrames();
      frames[frames.length - 1].setSize(COLUMN_WIDTH, height);
    }
    return good;
  }

  static void doubleClick(JTable table, int row) {
    Rectangle box = table.getCellRect(row, 0, false);
    table.dispatchEvent(new MouseEvent(table, MouseEvent.MOUSE_CLICKED, System.currentTimeMillis(), 0, box.x + 5,
                                       box.y + 5, 2, false, MouseEvent.BUTTON1));
  }

  static Object cell(JTable table, int row, String column) {
    return table.getValueAt(row, table.getColumnModel().getColumnIndex(column));
  }

  static JTable findTable(Container container) {
    for (Component component : container.getComponents()) {
      if (component instanceof JTable) return (JTable) component;
      JTable table = component instanceof Container ? findTable((Container) component) : null;
      if (table != null) return table;
    }
    return null;
  }

  /** The windows without their borders, one below the other in columns. */
  private static BufferedImage paintWindows() {
    BufferedImage image = new BufferedImage(2 * COLUMN_WIDTH, COLUMN_HEIGHT, BufferedImage.TYPE_INT_RGB);
    int x = 0;
    int y = 0;
    for (Frame frame : Frame.getFrames()) {
      JRootPane pane = ((JFrame) frame).getRootPane();
      if (y + pane.getHeight() > COLUMN_HEIGHT) {
        x += COLUMN_WIDTH;
        y = 0;
      }
      pane.printAll(image.getGraphics().create(x, y, pane.getWidth(), pane.getHeight()));
      y += pane.getHeight();
    }
    return image;
  }
}
