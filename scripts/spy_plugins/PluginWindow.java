package crsm.spy;

import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import java.beans.PropertyVetoException;
import javax.swing.JComponent;
import javax.swing.JDesktopPane;
import javax.swing.JInternalFrame;
import javax.swing.SwingUtilities;
import javax.swing.Timer;

/** A view that fills the window which lcm-spy makes for it. */
final class PluginWindow {
  private static final int REPAINT_MS = 50;

  private PluginWindow() {}

  /** Paints the view anew again and again until its window is closed; then calls `on_close`. */
  static void open(JDesktopPane desktop, String title, JComponent view, Runnable on_close) {
    Timer timer = new Timer(REPAINT_MS, tick -> view.repaint());
    timer.start();
    SwingUtilities.getWindowAncestor(desktop).addWindowListener(new WindowAdapter() {
      @Override
      public void windowClosing(WindowEvent closing) {
        timer.stop();
        on_close.run();
      }
    });
    JInternalFrame frame = new JInternalFrame(title, true, false, true, true);
    frame.add(view);
    desktop.add(frame);
    try {
      frame.setMaximum(true);
    } catch (PropertyVetoException vetoed) {
      frame.setSize(desktop.getSize());
    }
    frame.setVisible(true);
  }
}
