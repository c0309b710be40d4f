// optics holds the common part of all simulated pictures: the blur of a lens, dirt on its window.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace firn::plant {

/// A speck on the window: its opacity, with an edge out of focus.
struct Speck {
  double x_px = 0.0, y_px = 0.0, radius_px = 2.0, opacity = 0.5, blur_px = 1.0;
};

/// Sensor, lens, light and window of a camera.
struct Optics {
  int width = 640, height = 480, white = 255;
  double um_per_px = 2.0;
  double blur_px = 1.0;  ///< standard deviation of the point spread function
  double light = 0.7;    ///< mean level of the ground, share of white; above 1: saturated
  double slope_x = 0.0, slope_y = 0.0, vignette = 0.0;  ///< shares of the light, corner to middle
  double flicker = 0.0;                                 ///< standard deviation of the light's energy
  double read_noise = 0.004, shot_noise = 0.006;        ///< standard deviations at white, shares of white
  std::vector<Speck> dirt;                              ///< on the window
};

/// Convolves a picture of rows with a Gauss curve; beyond the edges it goes on as there.
void blur_picture(std::vector<float>& picture, int width, int height, double sigma_px);

/// Share of the light that the specks take, by pixel.
std::vector<float> soiled(std::span<const Speck> specks, int width, int height);

}  // namespace firn::plant
