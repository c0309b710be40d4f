// render_lines() renders the picture of printed lines in a camera over the substrate: physics and optics of
// its own, which no estimator knows.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

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

/// Sets the thickness of the dry ink over the part at many places.
using InkThickness =
    std::function<void(std::span<const double> x_mm, std::span<const double> y_mm, std::span<double> ink_mm)>;

/// @param thickness not called for an empty scene (nullptr)
/// @param exposure numbers the picture: another noise and flicker
TakenPicture render_lines(const LineCamera& camera, const InkThickness& thickness, std::uint64_t seed,
                          std::uint32_t exposure);

}  // namespace firn::plant
