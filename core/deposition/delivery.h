// count_delivery() computes the error of the volume that a list of drops delivers along a path, by counting.
#pragma once

#include <span>
#include <vector>

#include "core/deposition/flow_demand.h"
#include "core/deposition/pulses.h"

namespace firn::deposition {

struct Drop {
  double time_s = 0.0;  ///< since the start of the path
  double volume_mm3 = 0.0;
};

/// The drops of a plan: at their ticks, each with the volume that the valve's calibration gives at the flow
/// wanted then.
std::vector<Drop> drops_of(const PulsePlan& plan, const FlowDemand& demand, const FlowCurve& curve,
                           double tick_s);

/// Unavoidable error: volume comes in drops, drops come at ticks.
struct Granted {
  double drop_mm3 = 0.0;
  double tick_s = 0.0;
};
/// The largest drop of a demand (drops differ in size where the curve bends) and the tick.
Granted granted_by(const FlowDemand& demand, const FlowCurve& curve, double tick_s);

struct DeliveryError {
  double wanted_mm3 = 0.0;
  double delivered_mm3 = 0.0;
  double worst_mm3 = 0.0;  ///< largest |delivered - wanted| up to any point of the path
  double worst_at_s = 0.0;
  /// Largest |delivered - wanted| less the unavoidable error: half a drop and the volume wanted within the
  /// tick around that point. At most 0 when the bound holds.
  double worst_excess_mm3 = 0.0;
  double window_worst =
      0.0;  ///< over all windows of the length: |delivered / wanted - 1|; 0 for a shorter path
  double window_from_mm = 0.0;
  double widest_gap_mm = 0.0;  ///< between neighbouring drops, along the path
};

/// Exact suprema: drops are points, so extremes stand right at a drop. @pre drops ascending in time
DeliveryError count_delivery(const FlowDemand& demand, std::span<const Drop> drops, const Granted& granted,
                             double window_mm);

}  // namespace firn::deposition
