// SpatialIlc computes layers by norm-optimal iterative learning control in space: each layer is an iteration,
// and learns from the rise of the one before it.
#pragma once

#include <array>
#include <vector>

#include "core/control/controller.h"
#include "core/control/prediction.h"
#include "core/grid/cosine_transform.h"

namespace firn::control {

inline constexpr std::array kSpatialIlcOptions{
    ExtraOption{"ilc_change", 0.1, "", within(0, 1000),
                "weight of a change of dose, R by Q K(0)^2: 0 = all of the error is answered at once"},
    ExtraOption{"ilc_effort", 0.0, "", within(0, 1000), "weight of the dose itself, S by Q K(0)^2"},
};

/// The learning law, without rounding. Layer j rises by dH_j = K f_j + d_j, f the dose in droplets per cell,
/// K the convolution with [h3 h2 h3; h2 h1 h2; h3 h2 h3] and d what it leaves out. The next dose minimises
///   Q |r - dH_{j+1}|^2 + R |f_{j+1} - f_j|^2 + S |f_{j+1}|^2,   dH_{j+1} = dH_j + K (f_{j+1} - f_j),
/// r being the rise wanted of layer j + 1. With walls that reflect, K is diagonal in the cosine transform,
///   K(w) = h1 + 2 h2 (cos wx + cos wy) + 4 h3 cos wx cos wy,
/// and with e = r - dH_j each frequency is by itself:
///   f_{j+1} = [ (Q K^2 + R) f_j + Q K e ] / (Q K^2 + R + S).
/// For S = 0 a constant r is then approached by the factor R / (Q K^2 + R) a layer; R = 0 is dead beat. A
/// true kernel K (1 + m) is learned for real m with 0 < 1 + m < 2 (Q K^2 + R) / (Q K^2).
class LearningFilter {
 public:
  /// @param change, effort R and S by Q K(0)^2
  LearningFilter(const GridSpec& grid, const deposition::DropletModel& model, double change, double effort);
  /// @param dose f_j [droplets per cell] @param error e [mm]
  Grid<double> next_dose(const Grid<double>& dose, const Grid<double>& error);
  /// K of each frequency [mm], row by row.
  const std::vector<double>& kernel_mm() const { return kernel_; }

 private:
  GridSpec grid_;
  CosineTransform transform_;
  std::vector<double> kernel_, keep_, learn_;
};

/// Spatial iterative learning control, norm-optimal, in the setting of D. J. Hoelzle and K. L. Barton, "On
/// spatial iterative learning control via 2-D convolution: stability analysis and computational efficiency",
/// IEEE Trans. Control Syst. Technol. 24 (2016) 1504, of which the abstract alone was read: the formulation
/// is ours.
///
/// Layers do not repeat one reference: r of cell c in layer k + 1 is min((k + 1) dh, target) - H_c, which
/// contains the error of all layers so far. So the scheme is an integral controller of height whose gain
/// depends on frequency. f_j is the dose that was fired. Doses become droplets by error diffusion, and the
/// next measurement shows what the rounding did. Outside the mask dose and error are 0. Ends as MPC does when
/// a layer at the nominal height does not better the part beyond noise.
class SpatialIlc final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument naming the option
  SpatialIlc(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_options(const ControlOptions& options) override { noise_gate_ = options.noise_gate; }

 private:
  struct Memory {
    int layer = -1;
    HeightMap height;   ///< after it
    Grid<double> dose;  ///< decided from it
  };

  Setup setup_;
  double dh_mm_, noise_gate_;
  std::int64_t part_cells_;
  LearningFilter filter_;
  Predictor predict_;
  Memory before_, after_;
};

}  // namespace firn::control
