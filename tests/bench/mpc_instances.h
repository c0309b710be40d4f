// Computes the states on which the layer solvers are measured: 100 x 100 cells, Lu's Table I (4.4 / 0.6 / 0.2
// um), the lost border, target 50 um. tests/bench/instances holds them as float32 NPY files, which are the
// definition; this generator made them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/control/controller.h"

namespace firn::bench {

inline constexpr std::array kInstances{"half3.8", "half2.2", "ramp", "rough", "uniform", "loop"};
inline constexpr double kTarget_mm = 0.05;

/// Setup of an n x n part with a flat target.
control::Setup setup_of(int n);

/// half3.8, half2.2: that many um short everywhere; ramp: 0 to 7.6 um short along x; rough: 3.8 um short, +-
/// 1 um per cell; uniform: 0 to 7.6 um short, per cell; loop: the state before the last layers of a print of
/// 50 um by the greedy MPC, whose droplets are 0.65 to 1.35 of the model's. Heights are rounded to float32.
/// @throws std::invalid_argument: another name
HeightMap make_instance(const std::string& name, int n = 100, std::uint64_t seed = 1);

/// A shipped file. @throws std::runtime_error: not there
std::vector<std::byte> instance_bytes(const std::string& folder, const std::string& file);
HeightMap read_instance(const std::string& folder, const std::string& name);  ///< folder/name.npy
/// The best layer known: folder/best/name.npy
DropletPattern best_known(const std::string& folder, const std::string& name);

/// A heights file as float32, the definition of an instance.
std::vector<std::byte> float32_npy(const HeightMap& map);

/// Mean |error| [um] of a layer by the height-change model itself, in double precision.
double mean_error_um(const control::Setup& setup, const HeightMap& height, const DropletPattern& drops);

/// Rows become columns.
control::Setup transposed(const control::Setup& setup);
template <class Map>
Map transposed(const Map& map) {
  Map out(GridSpec{map.spec.ny, map.spec.nx});
  for (int j = 0; j < map.spec.ny; ++j)
    for (int i = 0; i < map.spec.nx; ++i) out.at(j, i) = map.at(i, j);
  return out;
}

}  // namespace firn::bench
