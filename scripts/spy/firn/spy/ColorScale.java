package firn.spy;

import java.awt.Color;

/** Viridis (S. van der Walt, N. Smith; CC0), from nine of its colours: the same scale as in Firn's reports. */
final class ColorScale {
  private static final int[] ANCHORS = {
    0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725
  };
  static final Color UNKNOWN = new Color(0xdddddd);

  private ColorScale() {}

  /** @param part 0 (lowest) to 1 (highest); not a number is grey */
  static int rgb(double part) {
    if (!(part == part)) return UNKNOWN.getRGB();
    double place = Math.max(0.0, Math.min(1.0, part)) * (ANCHORS.length - 1);
    int below = Math.min((int) place, ANCHORS.length - 2);
    double rest = place - below;
    int mixed = 0;
    for (int shift = 0; shift <= 16; shift += 8) {
      int a = ANCHORS[below] >> shift & 0xff;
      int b = ANCHORS[below + 1] >> shift & 0xff;
      mixed |= (int) Math.round(a + rest * (b - a)) << shift;
    }
    return mixed;
  }
}
