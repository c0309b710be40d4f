// Light, lens and noise of rendered pictures, drawn at random for the benches of core/vision.
#pragma once

#include "core/grid/random.h"
#include "plant/inkjet/optics.h"

namespace firn {

struct LightRange {
  double max_blur_px = 1.5, highest = 0.9, max_flicker = 0.02;
  std::uint32_t specks = 12;  // fewer than these
};

inline void draw_light(RandomStream& r, const LightRange& range, plant::Optics& c) {
  c.white = std::vector{255, 255, 1023, 4095}[r.below(4)];
  c.blur_px = r.uniform(0.6, range.max_blur_px);
  c.light = r.uniform(0.4, range.highest);
  if (r.uniform() < 0.1) c.light = r.uniform(0.98, 1.03);  // part of the ground is saturated
  c.slope_x = r.uniform(-0.3, 0.3);
  c.slope_y = r.uniform(-0.3, 0.3);
  c.vignette = r.uniform(0, 0.4);
  c.flicker = r.uniform(0, range.max_flicker);
}

inline void draw_noise(RandomStream& r, plant::Optics& c) {
  c.read_noise = r.uniform(0.002, 0.012);
  c.shot_noise = r.uniform(0.002, 0.012);
}

inline void draw_dirt(RandomStream& r, const LightRange& range, plant::Optics& c) {
  for (std::uint32_t k = r.below(range.specks); k > 0; --k)
    c.dirt.push_back({r.uniform(3, c.width - 3), r.uniform(3, c.height - 3), r.uniform(1, 6),
                      r.uniform(0.05, 0.5), r.uniform(0.5, 4)});
}

}  // namespace firn
