// HeightFilter estimates the surface from the droplets and the maps: a Kalman filter with one height and one
// variance per cell.
//   H- = f(H+, U; h)          the executed droplets by the height-change model [Lu 2015, Eqs. (3)-(5)],
//   P- = J P+ J' + rho^2 G    the earlier error and the variance by droplets of relative scatter rho,
//   K  = P- / (P- + R)        R: the map's noise,
//   H+ = H- + K (Z - H-),     P+ = (1 - K) P-.
// So the noise of one map does not reach the next layer; with noise R large against q = rho^2 G, P settles
// near sqrt(q R). Covariances between cells are left out (SurfaceFilter). Only + - * / sqrt.
#pragma once

#include <vector>

#include "estimators/droplet/options.h"
#include "estimators/droplet/surface_filter.h"

namespace firn::droplet {

class HeightFilter {
 public:
  /// @throws std::invalid_argument: a bad model, a scatter not finite or below 0.
  HeightFilter(const GridSpec& grid, const HeightFilterOptions& options);

  /// From the next layer on.
  void use_model(const deposition::DropletModel& model, double droplet_scatter);

  /// The bare substrate: a plane plus the map's spread beyond its noise. @param noise_std_mm of one cell,
  /// above 0; pooled over all maps, since the noise reported with single maps jumps with the sensor's
  /// resolution
  /// @throws std::invalid_argument: sizes, noise, a cell to be used without a height; nothing is changed
  /// then.
  void set_substrate(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);
  /// The next layer's passes in the order of firing, and the map after it. A cell that differs from the
  /// prediction by more than kOutlier standard deviations (a droplet that did not come) is taken from the
  /// map.
  void add_layer(std::vector<Pass> passes, const HeightMap& height, const std::vector<Use>& use,
                 double noise_std_mm);
  /// The last layer (or the substrate) was measured again: its map is replaced.
  void replace_map(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);
  /// The droplets since the last map are not known: the map alone counts.
  void start_anew(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);

  bool has_substrate() const { return has_substrate_; }
  const Surface& surface() const { return surface_; }
  /// Root of the mean variance over the mask.
  double std_mm(const Mask& mask) const;

  static constexpr double kOutlier = 5.0;

 private:
  void update_noise(double std_mm);
  void correct(const HeightMap& height, const std::vector<Use>& use);

  GridSpec grid_;
  HeightFilterOptions options_;
  SurfaceFilter filter_;
  bool has_substrate_ = false, on_substrate_ = false;
  Surface predicted_, surface_;  ///< before and after the newest map
  double noise_variance_mm2_ = 0.0;
  int reports_ = 0;  ///< maps with a reported noise
};

}  // namespace firn::droplet
