// layer_features computes the features of a print by which a laboratory is estimated and checked: numbers
// from fired droplets and measured maps alone, in three stretches of layers and over the whole print.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "estimators/droplet/identification.h"

namespace firn::lab {

/// Stretches of layers: the first, second and last third of a print.
inline constexpr int kStretches = 3;
inline constexpr int kMinLayers = 6;

/// Holds one print as its features are computed from.
struct FeatureInput {
  std::span<const droplet::PrintedLayer> layers;  ///< at least kMinLayers
  const Mask& mask;                               ///< of the part
  const HeightMap& target;
  double noise_std_mm = 0.0;  ///< of one cell, as the maps report it
};

/// Returns the number of values of layer_features: those of the stretches, one after the other, their means
/// over the stretches, then those of the whole print.
std::size_t feature_count();
/// Returns the name with the stretch: "tilt along x in the first third of the layers".
std::string feature_name(std::size_t feature);

/// Indices of the features that estimate a laboratory from the whole print: means and whole-print features,
/// without those that are zero on average in any laboratory that favours no direction.
std::vector<std::size_t> fitted_features();
/// Indices of the features of one stretch that tell about a laboratory's parameters.
std::vector<std::size_t> features_of_stretch(int stretch);
/// Indices of all checked features: the stretches' and the whole print's.
std::vector<std::size_t> checked_features();

/// Returns the features, all finite. Logarithms are taken where a feature is a scale, so that its scatter
/// hardly depends on its value.
/// @throws std::invalid_argument: too few layers, sizes that differ
std::vector<double> layer_features(const FeatureInput& input);

}  // namespace firn::lab
