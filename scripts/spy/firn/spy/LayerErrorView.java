package firn.spy;

import firn.layer_metrics_t;
import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.IAxis;
import info.monitorenter.gui.chart.IAxisScalePolicy;
import info.monitorenter.gui.chart.ITrace2D;
import info.monitorenter.gui.chart.axis.scalepolicy.AxisScalePolicyManualTicks;
import info.monitorenter.gui.chart.labelformatters.LabelFormatterNumber;
import info.monitorenter.gui.chart.traces.Trace2DSimple;
import java.awt.BasicStroke;
import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.GridLayout;
import java.io.IOException;
import java.text.DecimalFormat;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;
import javax.swing.BorderFactory;
import javax.swing.JFrame;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;

/** RMS, mean error and spread of the surface about the target, layer by layer, and the newest layer in words. */
final class LayerErrorView extends JPanel {
  private final Map<Integer, layer_metrics_t> layers = new TreeMap<>();  // a layer measured again replaces the first
  private final List<IAxis<?>> layerAxes = new ArrayList<>();
  private final JLabel words = new JLabel("waiting for the first layer");
  private final ITrace2D rms = trace("RMS about the target", 0xd62728);
  private final ITrace2D mean = trace("mean error", 0x1f77b4);
  private final ITrace2D spread = trace("standard deviation", 0x2ca02c);

  private LayerErrorView() {
    super(new BorderLayout());
    words.setBorder(BorderFactory.createEmptyBorder(8, 12, 8, 12));
    JPanel charts = new JPanel(new GridLayout(1, 2));
    charts.add(chart("error about the final height [um]", rms, mean));
    charts.add(chart("unevenness [um]", spread));
    add(words, BorderLayout.NORTH);
    add(charts, BorderLayout.CENTER);
  }

  private Chart2D chart(String what, ITrace2D... traces) {
    Chart2D chart = new Chart2D();
    for (ITrace2D t : traces) chart.addTrace(t);
    @SuppressWarnings("unchecked")  // the library's own axis takes any policy
    IAxis<IAxisScalePolicy> x = (IAxis<IAxisScalePolicy>) chart.getAxisX();
    x.setAxisTitle(new IAxis.AxisTitle("layer"));
    x.setAxisScalePolicy(new AxisScalePolicyManualTicks());
    x.setFormatter(new LabelFormatterNumber(new DecimalFormat("0")));
    layerAxes.add(x);
    chart.getAxisY().setAxisTitle(new IAxis.AxisTitle(what));
    chart.getAxisY().setPaintGrid(true);
    chart.setGridColor(new Color(0xdddddd));
    chart.setPreferredSize(new Dimension(400, 340));
    return chart;
  }

  private static ITrace2D trace(String name, int rgb) {
    ITrace2D t = new Trace2DSimple(name);
    t.setColor(new Color(rgb));
    t.setStroke(new BasicStroke(1.8f));
    return t;
  }

  static JFrame open(String channel) {
    LayerErrorView view = new LayerErrorView();
    JFrame frame = new JFrame(channel + " - layer error");
    frame.add(view);
    frame.pack();
    frame.setVisible(true);
    try {
      Bus.subscribe(
          channel,
          bytes -> {
            layer_metrics_t m = new layer_metrics_t(bytes);
            SwingUtilities.invokeLater(() -> view.show(m));
          });
    } catch (IOException noBus) {
      frame.setTitle(channel + ": " + noBus.getMessage());
    }
    return frame;
  }

  private void show(layer_metrics_t m) {
    layers.put(m.layer, m);
    for (ITrace2D t : new ITrace2D[] {rms, mean, spread}) t.removeAllPoints();
    int ticks = Math.max(1, layers.size() / 8);
    for (IAxis<?> x : layerAxes) {
      x.setMajorTickSpacing(ticks);
      x.setMinorTickSpacing(ticks);
    }
    for (layer_metrics_t l : layers.values()) {
      rms.addPoint(l.layer, 1e3 * l.rms_mm);
      mean.addPoint(l.layer, 1e3 * l.mean_error_mm);
      spread.addPoint(l.layer, 1e3 * l.std_mm);
    }
    String expected = m.layers_expected > 0 ? " of about " + m.layers_expected : "";
    words.setText(String.format(
        "<html><b>layer %d%s</b> &nbsp; height %.1f of %.1f um &nbsp; RMS %.2f um &nbsp; mean %+.2f um &nbsp; std %.2f um<br>"
            + "%d droplets (%d in all), %.4f mm&sup3; &nbsp; deposit %.1f s, cure %.1f s, scan %.1f s, decide %.3f s</html>",
        m.layer, expected, 1e3 * m.mean_height_mm, 1e3 * m.target_mean_mm, 1e3 * m.rms_mm, 1e3 * m.mean_error_mm,
        1e3 * m.std_mm, m.drops, m.drops_total, m.volume_mm3, m.deposit_s, m.cure_s, m.scan_s, m.decide_s));
  }
}
