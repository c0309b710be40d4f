package firn.spy;

import firn.grid_t;
import firn.height_map_t;
import firn.preview_t;
import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.event.MouseAdapter;
import java.awt.event.MouseEvent;
import java.awt.geom.Path2D;
import java.awt.image.BufferedImage;
import java.io.IOException;
import javax.swing.JFrame;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;

/** The measured surface: heat map above, cross-section along x below, through the row under the pointer. */
final class HeightMapView extends JPanel {
  private static final int LEFT = 70, TOP = 42, BAR = 16, BAR_ROOM = 84, LEAST_SECTION = 150;

  private int layer;
  private int nx, ny;
  private double pitchX, pitchY;
  private float[] height = new float[0];
  private double lowest, highest, mean;
  private BufferedImage image;
  private int chosenRow = -1;

  private HeightMapView() {
    setBackground(Color.WHITE);
    setPreferredSize(new Dimension(560, 700));
    addMouseMotionListener(
        new MouseAdapter() {
          @Override
          public void mouseMoved(MouseEvent event) {
            if (ny == 0) return;
            int side = side();
            int drawn = (int) Math.round(side * ny * pitchY / widest());
            int row = ny - 1 - (event.getY() - TOP) * ny / Math.max(1, drawn);
            chosenRow = row >= 0 && row < ny ? row : -1;
            repaint();
          }
        });
  }

  /** Opens a window on `channel`; preview = preview_t, else height_map_t. */
  static JFrame open(String channel, boolean preview) {
    HeightMapView view = new HeightMapView();
    JFrame frame = new JFrame(channel + " - height map");
    frame.add(view);
    frame.pack();
    frame.setVisible(true);
    try {
      Bus.subscribe(
          channel,
          bytes -> {
            if (preview) {
              preview_t m = new preview_t(bytes);
              SwingUtilities.invokeLater(() -> view.show(m.layer, m.grid, m.height_mm));
            } else {
              height_map_t m = new height_map_t(bytes);
              SwingUtilities.invokeLater(() -> view.show(m.layer, m.grid, m.height_mm));
            }
          });
    } catch (IOException noBus) {
      frame.setTitle(channel + ": " + noBus.getMessage());
    }
    return frame;
  }

  private void show(int newLayer, grid_t grid, float[] heightMm) {
    layer = newLayer;
    nx = grid.nx;
    ny = grid.ny;
    pitchX = grid.pitch_x_mm;
    pitchY = grid.pitch_y_mm;
    height = heightMm;
    lowest = Double.POSITIVE_INFINITY;
    highest = Double.NEGATIVE_INFINITY;
    double sum = 0;
    int known = 0;
    for (float h : height)
      if (h == h) {
        lowest = Math.min(lowest, h);
        highest = Math.max(highest, h);
        sum += h;
        ++known;
      }
    if (known == 0) lowest = highest = 0;
    mean = known == 0 ? Double.NaN : sum / known;
    image = new BufferedImage(nx, ny, BufferedImage.TYPE_INT_RGB);
    double span = Math.max(highest - lowest, 1e-6);
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) image.setRGB(i, ny - 1 - j, ColorScale.rgb((height[j * nx + i] - lowest) / span));
    repaint();
  }

  private double widest() {
    return Math.max(nx * pitchX, ny * pitchY);
  }

  private int side() {
    return Math.max(40, Math.min(getWidth() - LEFT - BAR_ROOM, getHeight() - TOP - LEAST_SECTION - 64));
  }

  @Override
  protected void paintComponent(Graphics plain) {
    super.paintComponent(plain);
    Graphics2D g = (Graphics2D) plain;
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setColor(Color.BLACK);
    if (image == null) {
      g.drawString("waiting for the first measured surface", LEFT, TOP);
      return;
    }
    g.drawString(String.format("layer %d    mean %.1f um    lowest %.1f um    highest %.1f um",
        layer, 1e3 * mean, 1e3 * lowest, 1e3 * highest), LEFT, 24);
    int side = side();
    int width = (int) Math.round(side * nx * pitchX / widest());
    int drawn = (int) Math.round(side * ny * pitchY / widest());
    g.drawImage(image, LEFT, TOP, width, drawn, null);
    paintBar(g, LEFT + width + 12, TOP, drawn);
    int row = chosenRow >= 0 ? chosenRow : ny / 2;
    int y = TOP + (int) Math.round((ny - row - 0.5) * drawn / ny);
    g.setColor(Color.RED);
    g.drawLine(LEFT, y, LEFT + width, y);
    g.setColor(Color.BLACK);
    g.drawString(String.format("%.2f mm x %.2f mm", nx * pitchX, ny * pitchY), LEFT, TOP + drawn + 16);
    paintSection(g, row, TOP + drawn + 40, width);
  }

  private void paintBar(Graphics2D g, int x, int y, int length) {
    for (int k = 0; k < length; ++k) {
      g.setColor(new Color(ColorScale.rgb(1.0 - (double) k / Math.max(1, length - 1))));
      g.drawLine(x, y + k, x + BAR, y + k);
    }
    g.setColor(Color.BLACK);
    for (int k = 0; k <= 4; ++k)
      g.drawString(String.format("%.1f", 1e3 * (lowest + (highest - lowest) * k / 4)), x + BAR + 4,
          y + (4 - k) * (length - 1) / 4 + 5);
    g.drawString("um", x, y - 6);
  }

  private void paintSection(Graphics2D g, int row, int top, int width) {
    int bottom = Math.min(getHeight() - 34, top + width / 2);
    double span = Math.max(highest - lowest, 1e-6);
    g.setColor(Color.GRAY);
    g.drawRect(LEFT, top, width, bottom - top);
    g.setColor(Color.BLACK);
    g.drawString(String.format("%.0f um", 1e3 * highest), 10, top + 10);
    g.drawString(String.format("%.0f um", 1e3 * lowest), 10, bottom);
    g.drawString(String.format("cross-section at y = %.2f mm (row %d)", (row + 0.5) * pitchY, row), LEFT, bottom + 18);
    Path2D line = new Path2D.Double();
    boolean pen = false;
    for (int i = 0; i < nx; ++i) {
      float h = height[row * nx + i];
      if (h != h) {
        pen = false;
        continue;
      }
      double x = LEFT + (i + 0.5) * width / nx;
      double y = bottom - (h - lowest) / span * (bottom - top);
      if (pen) line.lineTo(x, y);
      else line.moveTo(x, y);
      pen = true;
    }
    g.setColor(Color.RED);
    g.setStroke(new BasicStroke(1.5f));
    g.draw(line);
  }
}
