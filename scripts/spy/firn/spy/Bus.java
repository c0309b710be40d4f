package firn.spy;

import java.io.IOException;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.Loopback;

/** The run's bus (LCM_DEFAULT_URL, set by `firn spy`): one receiver for all of Firn's views. */
final class Bus {
  private static LCM lcm;

  interface Handler {
    void message(LCMDataInputStream bytes) throws IOException;
  }

  private Bus() {}

  /** Calls the handler, on the receiving thread, for every message of a channel. A message of another type is ignored. */
  static synchronized void subscribe(String channel, Handler handler) throws IOException {
    if (lcm == null) {
      lcm = new LCM();
      Loopback.join(lcm);
    }
    lcm.subscribe(
        channel,
        (bus, name, bytes) -> {
          try {
            handler.message(bytes);
          } catch (IOException foreign) {
            System.err.println("firn spy: " + name + ": " + foreign.getMessage());
          }
        });
  }
}
