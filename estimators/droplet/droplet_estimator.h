// h1, h2, h3 of the height-change model [Lu 2015, Eqs. (3)-(5)] from what was fired and what was measured,
// layer by layer, with their uncertainty.
//
// Objective: sum over cells and layers of Huber's loss of (measured - predicted) / standard deviation (a
// square up to 3, so that a droplet that did not come counts as one far off, not as nine), where each
// prediction is made from the surface that all earlier maps and the model give (SurfaceFilter). So
//  - the noise of one map, which enters two successive differences of maps with opposite signs, enters here
//  once;
//  - the surface inside sat() is not one noisy map but the filtered surface, and sat() is averaged over what
//  is left
//    of its error, so that noise does not pass for spreading (errors in variables);
// Minimised by NLopt (BOBYQA, bounded, ends on its count of evaluations). Intervals come from the spread of
// what the cells say (sandwich): a cell's differences of all layers are taken together, since the filter
// leaves them correlated, and with those of cells up to two apart, which may share a droplet. The assumed
// variances only weigh.
//
// With a memory of M layers all that a layer says counts (1 - 1/M)^age: exponential forgetting.
//
// Layers older than the window are kept as a quadratic in h1..h3, and the surface after them to first order
// in h1..h3, so that the work per layer does not grow.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "estimators/droplet/options.h"
#include "estimators/droplet/surface_filter.h"
#include "estimators/droplet/symmetric3.h"

namespace firn::droplet {

struct Estimate {
  deposition::DropletModel model;
  Symmetric3 covariance_mm2;  ///< of h1, h2, h3
  /// Smallest eigenvalue of the correlation matrix of what the layers say of h1, h2, h3 (without the prior):
  /// 0 = some combination of them has left no trace in the maps, 1 = each left its own.
  double excitation = 0.0;
  double droplet_scatter = 0.0;  ///< relative standard deviation of a droplet, by the differences
  double fit = 0.0;  ///< mean of difference^2 / variance; about 1 where the model explains the maps
  int layers = 0;    ///< learned from
  std::int64_t droplets = 0;
  std::int64_t evaluations = 0;  ///< of the objective, for this estimate

  double std_mm(int n) const;          ///< n = 0, 1, 2 for h1, h2, h3
  double layer_height_std_mm() const;  ///< of h1 + 4 h2 + 4 h3
};

class DropletEstimator {
 public:
  /// @throws std::invalid_argument naming the option.
  DropletEstimator(const GridSpec& grid, const EstimatorOptions& options);
  ~DropletEstimator();

  /// The map of the bare ground. @param noise_std_mm of one cell, above 0: pooled over all maps, and its
  /// scale is estimated as well
  /// @throws std::invalid_argument: sizes, noise, as for add_layer.
  void set_ground(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);
  /// The next layer: its passes in the order of firing, and the map after it. kLearn and kAnchor cells must
  /// have finite heights. @returns the estimate after it
  Estimate add_layer(std::vector<Pass> passes, const HeightMap& height, const std::vector<Use>& use,
                     double noise_std_mm);
  /// The last layer was measured again: its map is replaced.
  Estimate replace_map(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);

  bool has_ground() const { return has_ground_; }
  const Estimate& estimate() const { return estimate_; }

 private:
  struct Work;
  /// What a cell's differences say near the optimum: 1/2 h' information h - pull' h.
  struct CellTerms {
    Symmetric3 information;
    std::array<double, 3> pull{};
  };
  double add_layer_terms(std::size_t k, std::vector<CellTerms>& terms, double& count) const;
  void check(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm) const;
  void hear_noise(double std_mm);
  void fade();
  double noise_variance_mm2() const { return noise_scale_ * told_variance_mm2_; }
  Estimate update();
  void fix_references();
  void fit_scatter();
  double objective(const double* h_mm);
  void minimise();
  void start_at(const deposition::DropletModel& model, double ground_shift_mm,
                std::vector<double>& height_mm) const;
  void differences_at(const deposition::DropletModel& model, double ground_shift_mm,
                      std::vector<std::vector<double>>& out);
  void add_ground_terms(std::size_t k, const std::vector<double>& shifted, std::array<double, 3>& sum) const;
  void judge();
  void forget_oldest();
  double weight_of(std::size_t k) const;  ///< of layer k of the window, by its age

  GridSpec grid_;
  EstimatorOptions options_;
  SurfaceFilter filter_;
  bool has_ground_ = false;
  Layer ground_;                                    ///< its map
  Surface start_;                                   ///< before the window's first layer,
  deposition::DropletModel start_model_;            ///< as filtered with this,
  std::array<std::vector<double>, 3> start_slope_;  ///< and its derivatives by h1..h3
  std::vector<double> start_by_ground_;             ///< and by the bare ground's height
  double ground_variance_mm2_ = 0.0;                ///< of the bare ground's mean height
  std::vector<Layer> window_;
  deposition::DropletModel model_;
  double keep_ = 1.0;  ///< 1 - 1/M
  double scatter_ = 0.05;
  double told_variance_mm2_ = 0.0,
         noise_scale_ = 1.0;  ///< of the maps' noise: mean of what they tell, and how far off it is
  int told_ = 0;
  int layers_ = 0;
  std::int64_t droplets_ = 0, evaluations_ = 0;
  std::vector<CellTerms> old_;  ///< of the layers before the window
  Symmetric3 information_;      ///< sums of old_
  std::array<double, 3> pull_{}, old_ground_{};
  Symmetric3 prior_information_;
  std::unique_ptr<Work> work_;
  Estimate estimate_;
};

}  // namespace firn::droplet
