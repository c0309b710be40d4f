// table_height_mm computes the true height of the levelling table; add_lattice_noise adds smooth random
// patterns in the plane.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/random.h"
#include "plant/config/ice_config.h"

namespace firn::plant {

/// Returns the height of the bare table and of the jigs on it [mm]: feet bilinear between the corners, screws
/// biquadratic between nine places (both zero for a level table), a fixed unevenness of 80 mm length. Beyond
/// the table: -1000.
double table_height_mm(const IceTableParams& p, std::uint64_t seed, double x_mm, double y_mm);

/// Identifies one pattern of a seed.
struct PatternKey {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::kPattern;
  std::uint32_t layer = 0;
};
/// Adds a pattern of mean 0 and standard deviation `sigma` to each of nx x ny cells: normals on a lattice of
/// `length_mm`, smooth between (quadratic B-spline weights, scaled to the variance).
void add_lattice_noise(const PatternKey& key, double length_mm, double sigma, double cell_mm, int nx, int ny,
                       std::vector<float>& into);

}  // namespace firn::plant
