package lcm.spy;

import lcm.lcm.LCM;

/** The bus of lcm-spy itself, which its class keeps to its package. */
public final class SpyBus {
  private SpyBus() {}

  public static LCM of(Spy spy) {
    return spy.lcm;
  }
}
