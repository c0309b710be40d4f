package firn.spy;

import firn.height_map_t;
import firn.preview_t;
import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** Opens a heat map with a cross-section for HEIGHT_MAP and for HEIGHT_PREVIEW. */
public class HeightMapPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == height_map_t.LCM_FINGERPRINT || fingerprint == preview_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction("Height map") {
      @Override
      public void actionPerformed(ActionEvent event) {
        HeightMapView.open(channel.name, channel.fingerprint == preview_t.LCM_FINGERPRINT);
      }
    };
  }
}
