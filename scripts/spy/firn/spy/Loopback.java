package firn.spy;

import java.io.IOException;
import java.lang.reflect.Field;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.MulticastSocket;
import java.net.NetworkInterface;
import java.util.List;
import lcm.lcm.LCM;

/**
 * The loopback interface as a receiver's: Firn sends there and nowhere else, whereas LCM's Java joins its group on the
 * interface of the default route and offers no choice.
 */
final class Loopback {
  private Loopback() {}

  /** Lets the receiver of {@code owner}'s field {@code lcm} hear the loopback interface too. */
  static void joinOf(Object owner) throws IOException {
    join((LCM) field(owner, "lcm"));
  }

  static void join(LCM bus) throws IOException {
    NetworkInterface loopback = NetworkInterface.getByInetAddress(InetAddress.getLoopbackAddress());
    for (Object provider : (List<?>) field(bus, "providers")) {
      if (!provider.getClass().getSimpleName().equals("UDPMulticastProvider")) continue;
      InetAddress group = (InetAddress) field(provider, "inetAddr");
      ((MulticastSocket) field(provider, "sock")).joinGroup(new InetSocketAddress(group, 0), loopback);
    }
  }

  private static Object field(Object of, String name) throws IOException {
    try {
      Field field = of.getClass().getDeclaredField(name);
      field.setAccessible(true);
      return field.get(of);
    } catch (ReflectiveOperationException otherLibrary) {
      throw new IOException("this version of LCM's Java library has no " + of.getClass().getName() + "." + name);
    }
  }
}
