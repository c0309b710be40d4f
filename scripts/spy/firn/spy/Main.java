package firn.spy;

import firn.layer_metrics_t;
import java.awt.Frame;
import java.awt.Rectangle;
import java.awt.Robot;
import java.awt.Toolkit;
import java.io.File;
import java.io.IOException;
import java.util.HashSet;
import java.util.Set;
import javax.imageio.ImageIO;
import javax.swing.JFrame;
import javax.swing.SwingUtilities;
import javax.swing.Timer;
import lcm.lcm.Loopback;
import lcm.spy.Spy;
import lcm.spy.SpyBus;

/**
 * Starts lcm-spy on the run's bus with Firn's two views open beside it. Arguments: none, or {@code PICTURE LAYERS}:
 * after so many layers, or when the run ends, the screen is written to PICTURE (PNG) and the program ends.
 */
public final class Main {
  private static final int DRAW_MS = 700;  // the views draw within this time of a message

  private Main() {}

  public static void main(String[] args) throws Exception {
    if (args.length != 0 && args.length != 2) throw new IllegalArgumentException("PICTURE LAYERS, or nothing");
    SwingUtilities.invokeAndWait(Main::openWindows);
    if (args.length == 2) photograph(new File(args[0]), Integer.parseInt(args[1]));
  }

  private static void openWindows() {
    try {
      Loopback.join(SpyBus.of(new Spy(null)));  // takes LCM_DEFAULT_URL
    } catch (IOException noBus) {
      System.err.println("firn spy: no bus: " + noBus.getMessage());
      System.exit(1);
    }
    Rectangle screen = new Rectangle(Toolkit.getDefaultToolkit().getScreenSize());
    int left = screen.width * 11 / 20;
    JFrame map = HeightMapView.open("HEIGHT_PREVIEW", true);
    JFrame error = LayerErrorView.open("LAYER_METRICS");
    for (Frame frame : Frame.getFrames())
      if (frame != map && frame != error && frame.isVisible()) frame.setBounds(0, 0, left, screen.height * 11 / 20);
    error.setBounds(0, screen.height * 11 / 20, left, screen.height * 9 / 20);
    map.setBounds(left, 0, screen.width - left, screen.height);
  }

  private static void photograph(File picture, int layers) throws IOException {
    Set<Integer> seen = new HashSet<>();
    Runnable now = () -> {
      int after = seen.size();  // here, on the bus's thread: further layers may come in before the screen is taken
      SwingUtilities.invokeLater(() -> photographSoon(picture, after));
    };
    Bus.subscribe(
        "LAYER_METRICS",
        bytes -> {
          if (seen.add(new layer_metrics_t(bytes).layer) && seen.size() == layers) now.run();
        });
    Bus.subscribe(
        "RUN_END",
        bytes -> {
          if (seen.size() < layers) now.run();
        });
  }

  private static void photographSoon(File picture, int layers) {
    Timer timer = new Timer(DRAW_MS, event -> {
      try {
        Rectangle screen = new Rectangle(Toolkit.getDefaultToolkit().getScreenSize());
        if (!ImageIO.write(new Robot().createScreenCapture(screen), "png", picture)) throw new IOException("no PNG writer");
        System.out.println(picture + ": the screen after " + layers + " layers");
        System.exit(0);
      } catch (Exception trouble) {
        System.err.println("firn spy: " + picture + ": " + trouble.getMessage());
        System.exit(1);
      }
    });
    timer.setRepeats(false);
    timer.start();
  }
}
