// BeadLaw holds the height of a bead by the speed of its nozzle or torch: ln dh = a ln v + b, as in wire-arc
// deposition [Marcotte, Mishra, Wen et al., CASE 2025]. fit_bead_law() estimates it from all beads,
// BeadEstimator bead by bead.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace firn::bead {

struct BeadLaw {
  double a = 0.0, b = 0.0;  ///< b for v in mm/s and dh in mm
  double height_mm(double speed_mm_s) const;
};

struct Bead {
  int layer = 0;
  std::uint32_t segment = 0;
  double speed_mm_s = 0.0, height_mm = 0.0;  ///< above 0
};

struct BeadFit {
  BeadLaw law;
  double a_half_width = 0.0, b_half_width = 0.0;  ///< of 95 % intervals
  double reference_mm_s = 0.0;                    ///< geometric mean of the speeds
  double height_half_width = 0.0;                 ///< relative, of the height at this speed, 95 %
  double scatter = 0.0;                           ///< standard deviation of ln dh about the law
  double speed_spread = 0.0;                      ///< standard deviation of ln v
  std::int64_t beads = 0;
  int layers = 0, segments = 0;
};

/// Least squares over all beads. Errors of one layer and of one segment are correlated, so the variance is
/// the sum of those clustered by layers and by segments [Cameron, Gelbach, Miller, J. Bus. Econ. Stat. 29
/// (2011) 238; without the part that both count, which is conservative]; Student's t by the smaller number of
/// clusters.
/// @throws std::invalid_argument: fewer than three beads, a speed or height that is not above 0
BeadFit fit_bead_law(std::span<const Bead> beads);

/// Recursive least squares in ln v, ln dh with x = (ln v, 1): k = P x / (beta + x' P x), theta += k (y - x'
/// theta), P = (P - k x' P) / beta.
class BeadEstimator {
 public:
  /// @param start law before the first bead
  /// @param initial_p P = p I, relative to the variance of a bead; 0.05 as in the source above
  /// @param forgetting beta in (0, 1]; 1: nothing is forgotten
  explicit BeadEstimator(const BeadLaw& start, double initial_p = 0.05, double forgetting = 1.0);
  /// @pre both above 0
  void add(double speed_mm_s, double height_mm);
  const BeadLaw& law() const { return law_; }

 private:
  BeadLaw law_;
  double forgetting_;
  std::array<double, 3> p_;  // P11, P12 = P21, P22
};

}  // namespace firn::bead
