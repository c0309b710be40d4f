// DropletEstimator estimates h1, h2, h3 of the height-change model [Lu 2015, Eqs. (3)-(5)] and their
// covariance from fired droplets and measured maps, layer by layer.
//
// Objective: sum over cells and layers of Huber's loss of (measured - predicted) / standard deviation (a
// square up to 3, so that a droplet that did not come counts as one far off, not as nine). Each prediction is
// made from the surface that all earlier maps and the model give (SurfaceFilter). So
//  - the noise of one map, which enters two successive differences of maps with opposite signs, enters
//    once;
//  - the surface inside sat() is not one noisy map but the filtered surface, and sat() is averaged over its
//    remaining error, so that noise does not pass for spreading (errors in variables).
// Minimised by NLopt (BOBYQA, bounded, ends on its count of evaluations). Intervals come from the spread of
// the cells' scores (sandwich): a cell's differences of all layers are taken together, since the filter
// leaves them correlated, and with those of cells up to two apart, which may share a droplet. The assumed
// variances are weights only.
//
// With a memory of M layers the information of a layer has the weight (1 - 1/M)^age: exponential forgetting.
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
  /// Smallest eigenvalue of the correlation matrix of the layers' information on h1, h2, h3 (without the
  /// prior): 0 = some combination of them has left no trace in the maps, 1 = each left its own.
  double excitation = 0.0;
  Symmetric3 information;          ///< of the layers on h1, h2, h3, without the prior [1/mm^2]
  double droplet_scatter = 0.0;    ///< relative standard deviation of a droplet, by the differences
  std::array<bool, 3> at_bound{};  ///< h1, h2, h3: the fit ended at the end of its range
  bool scatter_at_bound = false;
  /// Variance over that of the prior: 1 = the layers say nothing of it.
  std::array<double, 3> prior_share{1.0, 1.0, 1.0};
  double fit = 0.0;  ///< mean of difference^2 / variance; about 1 where the model explains the maps
  int layers = 0;    ///< in the fit
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

  /// The map of the bare substrate. @param noise_std_mm of one cell, above 0: pooled over all maps, and its
  /// scale is estimated as well
  /// @throws std::invalid_argument: sizes, noise, as for add_layer.
  void set_substrate(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);
  /// The next layer: its passes in the order of firing, and the map after it. kLearn and kAnchor cells must
  /// have finite heights. @returns the estimate after it
  Estimate add_layer(std::vector<Pass> passes, const HeightMap& height, const std::vector<Use>& use,
                     double noise_std_mm);
  /// The same without an estimate: the layer counts in that of the next add_layer(). For
  /// records, which need no estimate after each layer.
  /// @throws as add_layer
  void keep_layer(std::vector<Pass> passes, const HeightMap& height, const std::vector<Use>& use,
                  double noise_std_mm);
  /// Returns excitation and information of the kept layers about the present model, without a fit: a
  /// hundredth of its work. @pre a layer is kept, none left the window
  Estimate look();
  /// The last layer was measured again: its map is replaced.
  Estimate replace_map(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm);

  /// A volume that a camera saw, as the height h1 + 4 h2 + 4 h3 of a layer of such droplets: beside the prior
  /// and the maps, weighted by its variance, in the place of the one before. It counts at once before the
  /// first layer, later with the next map.
  /// @throws std::invalid_argument: a height or a standard deviation that is not above 0
  void believe_height(double layer_height_mm, double std_mm);

  bool has_substrate() const { return has_substrate_; }
  const Estimate& estimate() const { return estimate_; }

 private:
  struct Work;
  /// Quadratic model of a cell's loss near the optimum: 1/2 h' information h - information_vector' h.
  struct CellTerms {
    Symmetric3 information;
    std::array<double, 3> information_vector{};
  };
  double add_layer_terms(std::size_t k, std::vector<CellTerms>& terms, double& count) const;
  void update_noise(double std_mm);
  void forget();
  double noise_variance_mm2() const { return noise_scale_ * reported_variance_mm2_; }
  Estimate update();
  void fix_references();
  void fit_scatter();
  double objective(const double* h_mm);
  void minimise();
  void start_at(const deposition::DropletModel& model, double substrate_shift_mm,
                std::vector<double>& height_mm) const;
  void differences_at(const deposition::DropletModel& model, double substrate_shift_mm,
                      std::vector<std::vector<double>>& out);
  void add_substrate_terms(std::size_t k, const std::vector<double>& shifted,
                           std::array<double, 3>& sum) const;
  void update_fit();
  void forget_oldest();
  void add_seen(Symmetric3& information) const;
  double weight_of(std::size_t k) const;  ///< of layer k of the window, by its age

  GridSpec grid_;
  EstimatorOptions options_;
  SurfaceFilter filter_;
  bool has_substrate_ = false;
  int waiting_ = 0;                                 ///< last layers of the window that no estimate has seen
  Layer substrate_;                                 ///< its map
  Surface start_;                                   ///< before the window's first layer,
  deposition::DropletModel start_model_;            ///< as filtered with this,
  std::array<std::vector<double>, 3> start_slope_;  ///< and its derivatives by h1..h3
  std::vector<double> start_by_substrate_;          ///< and by the bare substrate's height
  double substrate_variance_mm2_ = 0.0;             ///< of the bare substrate's mean height
  std::vector<Layer> window_;
  deposition::DropletModel model_;
  std::array<bool, 3> at_bound_{};
  double keep_ = 1.0;  ///< 1 - 1/M
  double scatter_ = 0.05;
  double reported_variance_mm2_ = 0.0,
         noise_scale_ = 1.0;  ///< of the maps' noise: mean of the reported ones, and its correction factor
  int reports_ = 0;
  int layers_ = 0;
  std::int64_t droplets_ = 0, evaluations_ = 0;
  std::vector<CellTerms> old_;  ///< of the layers before the window
  Symmetric3 information_;      ///< sums of old_
  std::array<double, 3> information_vector_{}, old_substrate_{};
  Symmetric3 prior_information_;
  double seen_height_mm_ = 0.0, seen_information_ = 0.0;  ///< of believe_height(); 0: none
  std::unique_ptr<Work> work_;
  Estimate estimate_;
};

}  // namespace firn::droplet
