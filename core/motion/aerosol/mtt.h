// Computes minimum-time moves of one axis and of two that must arrive together [Thompson 2014, IV], with the
// corrections of (22), (24), (26), (37), of Fig. 5 (the minimum over all valid candidates, not the first
// valid one) and of IV-B (the next time that both axes can do, where the faster axis cannot take the slower
// axis' minimum).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/motion/aerosol/axis_profile.h"

namespace firn::motion {

/// Bounds of one axis. (31), (32): boundary speeds beyond v_max have no move.
struct AxisLimits {
  double v_max_mm_s = 0.0;
  double alpha_mm_s2 = 0.0;
};

/// v_p1 .. v_p4 of (23), (25), in this order; none where imaginary (27) or t0 <= tb <= t1 (28) is broken. A
/// candidate faster than v_max has become the trapezoid of (36) to (38).
using MttCandidates = std::array<std::optional<AxisProfile>, 4>;
MttCandidates mtt_candidates(const AxisEnds& ends, double t0_s, const AxisLimits& limits);

/// The valid candidate that ends first. @pre |v0|, |v1| <= v_max
AxisProfile mtt(const AxisEnds& ends, double t0_s, const AxisLimits& limits);

/// Durations from `from_s` to `to_s` (may be infinite).
struct Durations {
  double from_s = 0.0, to_s = 0.0;
};

/// All durations in which the axis can make the move within its limits: one or two intervals, the last one
/// without end. Two when both boundary speeds point the same way: the axis passes through, or it must loop
/// back.
std::vector<Durations> possible_durations(const AxisEnds& ends, const AxisLimits& limits);

/// The two axes of one move.
struct PlaneMove {
  AxisProfile x, y;
};

/// Both axes leave at t0 and arrive at the same time, the earliest that both can do, not before t0 +
/// at_least_s.
PlaneMove synchronised_mtt(const AxisEnds& x, const AxisEnds& y, double t0_s, const AxisLimits& limits,
                           double at_least_s = 0.0);

}  // namespace firn::motion
