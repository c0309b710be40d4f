package firn.spy;

import firn.layer_metrics_t;
import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** Opens the error of each layer for LAYER_METRICS. */
public class LayerErrorPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == layer_metrics_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction("Layer error") {
      @Override
      public void actionPerformed(ActionEvent event) {
        LayerErrorView.open(channel.name);
      }
    };
  }
}
