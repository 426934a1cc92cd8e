import java.awt.*;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import java.io.File;
import javax.imageio.ImageIO;
import javax.swing.*;

/**
 * Runs lcm-spy for some seconds, opens the view of the first laser as a user would, and writes all windows to a PNG.
 * Fails when no channel came or one could not be decoded. Arguments: FILE.png SECONDS.
 */
public class SpyScreenshot {
  public static void main(String[] arguments) throws Exception {
    lcm.spy.Spy.main(new String[0]);
    Frame.getFrames()[0].setSize(800, 300);
    Thread.sleep(1000L * Integer.parseInt(arguments[1]));
    boolean[] good = new boolean[1];
    SwingUtilities.invokeAndWait(() -> good[0] = readTable(findTable(Frame.getFrames()[0])));
    Thread.sleep(2000);  // for the view that it opened to draw a sweep
    BufferedImage[] image = new BufferedImage[1];
    SwingUtilities.invokeAndWait(() -> image[0] = paintWindows());
    ImageIO.write(image[0], "png", new File(arguments[0]));
    System.exit(good[0] ? 0 : 1);
  }

  /** Prints the table of channels, opens the view of the first laser. True if all is well. */
  private static boolean readTable(JTable table) {
    boolean good = table.getRowCount() > 0;
    if (!good) System.err.println("no message came on any channel");
    boolean opened = false;
    for (int row = 0; row < table.getRowCount(); ++row) {
      Object type = cell(table, row, "Type");
      System.out.printf("%-20s %-20s %6s messages, %s undecodable%n", cell(table, row, "Channel"), type,
                        cell(table, row, "Num Msgs"), cell(table, row, "Undecodable"));
      if (cell(table, row, "Channel").equals("LCM_SELF_TEST")) continue;  // no message: each program greets itself so
      good &= !type.toString().startsWith("??") && "0".equals(cell(table, row, "Undecodable").toString());
      if (!opened && type.equals("planar_lidar_t")) {
        Rectangle box = table.getCellRect(row, 0, false);
        table.dispatchEvent(new MouseEvent(table, MouseEvent.MOUSE_CLICKED, System.currentTimeMillis(), 0, box.x + 5,
                                           box.y + 5, 2, false, MouseEvent.BUTTON1));
        opened = true;
      }
    }
    return good;
  }

  private static Object cell(JTable table, int row, String column) {
    return table.getValueAt(row, table.getColumnModel().getColumnIndex(column));
  }

  private static JTable findTable(Container container) {
    for (Component component : container.getComponents()) {
      if (component instanceof JTable) return (JTable) component;
      JTable table = component instanceof Container ? findTable((Container) component) : null;
      if (table != null) return table;
    }
    return null;
  }

  /** The windows without their borders, one below the other. */
  private static BufferedImage paintWindows() {
    int width = 1;
    int height = 0;
    for (Frame frame : Frame.getFrames()) {
      width = Math.max(width, ((JFrame) frame).getRootPane().getWidth());
      height += ((JFrame) frame).getRootPane().getHeight();
    }
    BufferedImage image = new BufferedImage(width, height, BufferedImage.TYPE_INT_RGB);
    int y = 0;
    for (Frame frame : Frame.getFrames()) {
      JRootPane pane = ((JFrame) frame).getRootPane();
      pane.printAll(image.getGraphics().create(0, y, pane.getWidth(), pane.getHeight()));
      y += pane.getHeight();
    }
    return image;
  }
}
