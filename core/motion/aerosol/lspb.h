// Computes linear segments with parabolic blends (LSPB): a move of one axis in a given time [Thompson 2014,
// III], with the corrections of the misprints in (9), (15), (16): the time in their denominators is t1 - t0,
// not t1 + t0.
#pragma once

#include <array>
#include <optional>

#include "core/motion/aerosol/axis_profile.h"

namespace firn::motion {

/// The six candidates v_c1 .. v_c6 of (11), (13), (15), (16), in this order; none where it is imaginary (17),
/// infinite, or breaks t0 <= tb0 <= tb1 <= t1 (18). Rounding up to 1e-9 of the duration is forgiven, and the
/// blend times clamped.
using LspbCandidates = std::array<std::optional<AxisProfile>, 6>;
LspbCandidates lspb_candidates(const AxisEnds& ends, double t0_s, double t1_s, double alpha_mm_s2);

/// The valid candidate with the smallest |v_c|; none when the move has no solution in this time. Valid
/// candidates describe the same motion (the position reached at fixed times grows strictly with the speed of
/// the plateau), except that a plateau of no length leaves v_c open.
/// @param alpha_mm_s2 > 0
std::optional<AxisProfile> lspb(const AxisEnds& ends, double t0_s, double t1_s, double alpha_mm_s2);

}  // namespace firn::motion
