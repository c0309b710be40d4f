package lcm.lcm;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.NetworkInterface;

/** Joins a bus on the interface lo as well, the only one that Firn sends by: LCM joins where the default route leads. */
public final class Loopback {
  private Loopback() {}

  public static void join(LCM bus) throws IOException {
    for (Provider provider : bus.providers)
      if (provider instanceof UDPMulticastProvider udp)
        udp.sock.joinGroup(new InetSocketAddress(udp.inetAddr, udp.inetPort), NetworkInterface.getByName("lo"));
  }
}
