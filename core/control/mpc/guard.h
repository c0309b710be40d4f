// useful_share() computes the share of a layer's height that fills missing height. MPC requires a minimum, so
// that every print ends.
#pragma once

#include "core/control/controller.h"

namespace firn::control::mpc {

/// Least share of a layer's height that must go where height is missing.
inline constexpr double kMinUseful = 0.1;

/// Returns the share of a layer's height, by the model, that fills cells up to their targets: the fall of S =
/// sum over the part of max(0, h_d - H), over the rise of sum H. 0 when it adds nothing. With alpha = 1 and N
/// = 1 a layer that improves the objective is always useful by more than 1/2. For alpha < 1 an even surface
/// can be worth more than its height, layer after layer [errata on Eq. (8), Lu 2015]; for N > 1 a layer may
/// only prepare others. If every printed layer is useful by kMinUseful, and droplets are at least a part r
/// > 0 of the model's, each layer takes at least r kMinUseful h1 off S >= 0, so that any print ends.
double useful_share(const Setup& setup, const HeightMap& height, const DropletPattern& drops,
                    const MaterialMap& materials);

}  // namespace firn::control::mpc
