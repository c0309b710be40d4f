// StallDetector finds that layers no longer better the part about a target.
#pragma once

#include <vector>

#include "core/control/controller.h"

namespace firn::control {

/// Holds the measured mean |error| and RMS about a target for each layer that was printed towards it. After n
/// further layers both are compared with their least values before these. The print has stalled if neither
/// is less by more than kSigmas standard deviations of the difference of two such means,
///   kSigmas * noise_std * sqrt(2 / cells):
/// the gain of n layers is then within the noise of the measurement. While the part rises by layers the mean
/// |error| falls by a layer each time. Layers that were printed towards another target are not handed in: a
/// scheme that waits in one place improves nothing in another.
class StallDetector {
 public:
  static constexpr double kSigmas = 3.0;

  /// Forgets layers from `layer` on: it is measured again, or the print has begun again.
  void rewind(int layer);
  void clear() { layers_.clear(); }
  /// Adds a measurement after rewind(). Only cells of `cells` count. @pre `cells` is not empty
  void add(const Measurement& measurement, const HeightMap& target, const Mask& cells);
  /// Returns whether the last n layers have bettered the part by no more than noise. 0: never
  bool stalled(int n) const;

 private:
  struct Quality {
    int layer = 0;
    double mean_mm = 0.0, rms_mm = 0.0, noise_mm = 0.0;
  };
  std::vector<Quality> layers_;  ///< ascending
};

}  // namespace firn::control
