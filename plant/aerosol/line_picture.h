// render_lines() renders the picture of printed lines in a camera over the substrate: physics and optics of
// its own, which no estimator knows.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "plant/inkjet/optics.h"
#include "plant/twins/camera.h"

namespace firn::plant {

struct LineCamera : Optics {
  LineCamera() {
    width = height = 320;
    um_per_px = 4.0;
  }
  double x_mm = 0.0, y_mm = 0.0;    ///< of the picture's middle over the part; its rows go up in y
  double turn = 0.0;                ///< of the camera about its axis [rad]
  double optical_depth_mm = 0.002;  ///< thickness of dry ink that lets 1/e of the light through
  double contrast = 0.95;           ///< share of the light that thick ink takes, or
  bool bright = false;              ///< adds, on a darker ground
};

/// Share of the contrast that ink of this thickness has [Beer and Lambert].
double ink_contrast(double thickness_mm, double optical_depth_mm);

/// @param thickness_mm of the dry ink over the part, by place; not called for an empty scene (nullptr)
/// @param exposure numbers the picture: another noise and flicker
TakenPicture render_lines(const LineCamera& camera, const std::function<double(double, double)>& thickness_mm,
                          std::uint64_t seed, std::uint32_t exposure);

}  // namespace firn::plant
