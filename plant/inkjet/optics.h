// optics holds the common part of all simulated pictures: the blur of a lens, dirt on its window.
#pragma once

#include <span>
#include <vector>

namespace firn::plant {

/// A speck on the window: its opacity, with an edge out of focus.
struct Speck {
  double x_px = 0.0, y_px = 0.0, radius_px = 2.0, opacity = 0.5, blur_px = 1.0;
};

/// Convolves a picture of rows with a Gauss curve; beyond the edges it goes on as there.
void blur_picture(std::vector<float>& picture, int width, int height, double sigma_px);

/// Share of the light that the specks take, by pixel.
std::vector<float> soiled(std::span<const Speck> specks, int width, int height);

}  // namespace firn::plant
