package lcm.lcm;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.NetworkInterface;

/**
 * Moves a bus to the interface lo, the only one that Firn sends by: LCM joins where the default route leads, and where
 * that is lo itself, as on a computer without a network, a second membership would be refused.
 */
public final class Loopback {
  private Loopback() {}

  public static void join(LCM bus) throws IOException {
    for (Provider provider : bus.providers)
      if (provider instanceof UDPMulticastProvider udp) {
        leave(udp);
        udp.sock.joinGroup(new InetSocketAddress(udp.inetAddr, udp.inetPort), NetworkInterface.getByName("lo"));
      }
  }

  @SuppressWarnings("deprecation")  // as LCM has joined
  private static void leave(UDPMulticastProvider udp) throws IOException {
    udp.sock.leaveGroup(udp.inetAddr);
  }
}
