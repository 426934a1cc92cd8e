package crsm.spy;

import bot_core.planar_lidar_t;
import crsm.sweep_t;
import java.awt.*;
import java.awt.event.*;
import java.awt.geom.*;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.text.DecimalFormat;
import java.util.Arrays;
import javax.swing.*;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** Draws the newest sweep of a laser when its channel is double-clicked in lcm-spy. */
public class LaserPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == planar_lidar_t.LCM_FINGERPRINT || fingerprint == sweep_t.LCM_FINGERPRINT;
  }

  /** lcm-spy also asks with nulls, for the name. */
  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction("Laser view") {
      @Override
      public void actionPerformed(ActionEvent event) {
        PluginWindow.open(desktop, "Laser view", new LaserPanel(channel), () -> {});
      }
    };
  }

  /** The laser stands in the middle; x right, y up, as on the map. The wheel zooms, a double-click fits. */
  private static class LaserPanel extends JPanel {
    private final ChannelData channel;
    private double reach_m = 0;  // from the middle to the nearer border; 0: fit the next sweep

    LaserPanel(ChannelData channel) {
      this.channel = channel;
      setBackground(Color.WHITE);
      addMouseWheelListener(event -> reach_m *= Math.pow(1.2, event.getWheelRotation()));
      addMouseListener(new MouseAdapter() {
        @Override
        public void mouseClicked(MouseEvent event) {
          if (event.getClickCount() == 2) reach_m = 0;
        }
      });
    }

    /** Where CLASSPATH names the jar, lcm-spy has loaded the same type by another loader: only its bytes fit ours. */
    private static planar_lidar_t copy(LCMEncodable message) {
      try {
        LCMDataOutputStream bytes = new LCMDataOutputStream();
        message.encode(bytes);
        if (isSweep(bytes.toByteArray())) return drawn(new sweep_t(bytes.toByteArray()));
        return new planar_lidar_t(bytes.toByteArray());
      } catch (IOException impossible) {
        throw new UncheckedIOException(impossible);  // to and from memory
      }
    }

    private static boolean isSweep(byte[] message) {
      return ByteBuffer.wrap(message).getLong() == sweep_t.LCM_FINGERPRINT;
    }

    /** What is drawn of a sweep: not when each beam was measured. */
    private static planar_lidar_t drawn(sweep_t sweep) {
      planar_lidar_t scan = new planar_lidar_t();
      scan.utime = sweep.utime;
      scan.nranges = sweep.num_beams;
      scan.ranges = sweep.range_m;
      scan.rad0 = sweep.angle_min_rad;
      scan.radstep = sweep.angle_step_rad;
      return scan;
    }

    private static boolean isReturn(float range_m) {
      return range_m > 0 && !Float.isInfinite(range_m);  // NaN is not > 0
    }

    /** Twice the median: beams without return, which many lasers report as 80 m, do not shrink the room. */
    private static double fit(planar_lidar_t scan) {
      float[] ranges_m = new float[scan.nranges];
      int num_returns = 0;
      for (float range_m : scan.ranges) {
        if (isReturn(range_m)) ranges_m[num_returns++] = range_m;
      }
      Arrays.sort(ranges_m, 0, num_returns);
      return num_returns == 0 ? 0 : 2.0 * ranges_m[num_returns / 2];
    }

    @Override
    protected void paintComponent(Graphics graphics) {
      super.paintComponent(graphics);
      if (channel.last == null) return;
      planar_lidar_t scan = copy((LCMEncodable) channel.last);
      if (reach_m == 0) reach_m = fit(scan);
      double shown_m = reach_m > 0 ? reach_m : 10;
      double pixels_per_m = 0.5 * Math.min(getWidth(), getHeight()) / shown_m;
      Graphics2D g = (Graphics2D) graphics;
      g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
      double x0 = 0.5 * getWidth();
      double y0 = 0.5 * getHeight();

      int num_returns = 0;
      Path2D beams = new Path2D.Double();
      Path2D hits = new Path2D.Double();
      for (int i = 0; i < scan.nranges; ++i) {
        if (!isReturn(scan.ranges[i])) continue;
        ++num_returns;
        double angle_rad = scan.rad0 + i * scan.radstep;
        double x = x0 + pixels_per_m * scan.ranges[i] * Math.cos(angle_rad);
        double y = y0 - pixels_per_m * scan.ranges[i] * Math.sin(angle_rad);
        beams.moveTo(x0, y0);
        beams.lineTo(x, y);
        hits.append(new Rectangle2D.Double(x - 1.5, y - 1.5, 3, 3), false);
      }
      g.setColor(new Color(205, 225, 245));
      g.draw(beams);
      drawGrid(g, x0, y0, shown_m, pixels_per_m);
      g.setColor(new Color(190, 30, 30));
      g.fill(hits);
      g.setColor(Color.BLACK);
      g.drawString(String.format("%s   utime %d   %d beams, %d returns", channel.name, scan.utime, scan.nranges,
                                 num_returns), 8, 16);
    }

    /** Rings 1, 2 or 5 times a power of ten metres apart, out to the corners. */
    private static void drawGrid(Graphics2D g, double x0, double y0, double shown_m, double pixels_per_m) {
      double step_m = Drawing.roundLengthM(shown_m / 2);
      g.setColor(Color.GRAY);
      for (double r_m = step_m; r_m * pixels_per_m < Math.hypot(x0, y0); r_m += step_m) {
        double r = r_m * pixels_per_m;
        g.draw(new Ellipse2D.Double(x0 - r, y0 - r, 2 * r, 2 * r));
        g.drawString(new DecimalFormat("0.### m").format(r_m), (float) (x0 + r + 2), (float) (y0 - 2));
      }
      g.draw(new Line2D.Double(0, y0, 2 * x0, y0));
      g.draw(new Line2D.Double(x0, 0, x0, 2 * y0));
    }
  }
}
