// solve_profile() computes the minimum-time speed profile within the limits of speed, acceleration and jerk
// on a fixed curve by a primal-dual interior-point method with one banded Newton step per iteration.
// Derivation: docs/algorithms/certified-motion.md.
// The band is eliminated by hand: Eigen solves dense and general sparse systems, not banded ones.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/motion/time_optimal/constants.h"
#include "core/motion/time_optimal/motion_rows.h"

namespace firn::motion {

/// A profile that does not begin at rest: the state at the ends of its first cell is given, and what followed
/// there in the profile of which it is the continuation.
struct ProfileStart {
  double b[2] = {}, slope[2] = {};  ///< b and b' at knots 0 and 1, b > 0
  std::vector<double> s, ahead;     ///< that profile's b at places s of the curve, ascending: a first guess
  double ahead_mm = 0.0;            ///< from the start on, within which it is as good as the whole
};

struct ProfileOptions {
  double gap =
      0.008;  ///< stop when duality gap / duration plus violation / 3 is below this (less on long ones)
  int max_iterations = 40;
  const ProfileStart* start = nullptr;  ///< null = from rest
};

/// b(s) = (ds/dt)^2, continuous with its slope b'. In cell i, b'' = curve (1 + bend (x - 1/2)) with x from 0
/// to 1 across the cell and a fixed bend, so that constant jerk (b'' proportional to 1 / sqrt(b)) is within
/// reach of one unknown per cell. In the first and last cell b is proportional to y^(4/3), y = distance from
/// the rest: constant jerk from v = a = 0. A profile with a ProfileStart has no first rest.
struct Profile {
  std::vector<double> b;      ///< at the knots [mm^2/s^2]
  std::vector<double> slope;  ///< b' at the knots [mm/s^2], twice the path acceleration
  std::vector<double> bend;   ///< of each cell
  int iterations = 0;
  int groups = 0;          ///< of rows, active in the end
  double gap = 0.0;        ///< relative duality gap at the end
  double violation = 0.0;  ///< largest relative excess over a limit at the end

  /// b'' at the left (side 0) or right end of an inner cell of length h.
  double second(std::size_t cell, int side, double h) const {
    return (slope[cell + 1] - slope[cell]) / h * (1.0 + (side ? 0.5 : -0.5) * bend[cell]);
  }
};

/// dT / d(r', r'', r''') of the tool's path r at the samples of MotionRows, from the multipliers of the
/// limits of the total motion: by how much the optimum would change with the curve.
struct TimeGradient {
  std::vector<double> x[3], y[3];  ///< [order - 1][2 * cells]
};

/// Buffers of the solver, kept between paths: arrays of one double per cell or knot.
class ProfileWork {
 public:
  /// Makes room for `arrays` arrays of `length` doubles each. The first and the last kZeroEdge of each are
  /// zero, those between them are what they happen to be: callers write them first.
  void resize(std::size_t arrays, std::size_t length) {
    stride_ = (length + 7) / 8 * 8;
    if (memory_.size() < arrays * stride_) memory_.resize(arrays * stride_);
    for (std::size_t i = 0; i < arrays; ++i) {
      double* const a = array(i);
      std::fill(a, a + std::min(kZeroEdge, length), 0.0);
      std::fill(a + std::max(kZeroEdge, length) - kZeroEdge, a + stride_, 0.0);
    }
  }
  double* array(std::size_t i) { return memory_.data() + i * stride_; }

 private:
  std::vector<double> memory_;
  std::size_t stride_ = 0;
};

/// @param top largest b at each knot (rates and speed limits); @param bound the speed-and-acceleration
/// optimum at the knots, from which the first guess is made. The first @p active groups are active
/// constraints from the beginning. Another group is activated when the profile exceeds its limits: without
/// these limits the optimum can only be faster, so an optimum that satisfies them is the optimum with all of
/// them. On return the active groups come first.
/// @param gradient filled unless null
/// @pre curve.cells() >= 4
void solve_profile(const Curve& curve, const MotionRows& rows, RowGroups& groups, int active,
                   const std::vector<double>& top, const std::vector<double>& bound,
                   const ProfileOptions& options, ProfileWork& work, Profile& out,
                   TimeGradient* gradient = nullptr);

}  // namespace firn::motion
