// plan_pulses() computes the valve's pulse list for a path by frequency modulation [Barnett 2012, 6.2]: one
// entry per drop.
//
//   (6.4) nu_i = h(Q_i)    (6.5) n_i = delta sum_{j<=i} nu_j    (6.6) pulses where n reaches 0.5, 1.5, ...
//
// Departures. (6.5) as printed is a rectangle rule that lets sample i stand for a whole step before its
// instant: pulses come delta / 2 = 8 ms too early, 1 mm at 125 mm/s. Here n is the exact integral of nu,
// linear between instants. Pulse values as in the errata: 0.5, 1.5, ..., ceil(max n - 0.5) - 0.5. Where h
// bends, drops differ in size and n no longer counts volume; so plan_pulses() fires when the wanted volume
// leads the delivered one by half a drop of size Q / h(Q), h being evaluated at each tick of the controller.
// For a straight h that is (6.5), (6.6); for any h no error grows. An instant is rounded to the nearest tick;
// pulses at most one per tick stay apart.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/deposition/flow_demand.h"
#include "core/deposition/valve.h"

namespace firn::deposition {

/// Eq. (6.5) as printed: n_i = delta sum_{j=1..i} nu_j.
std::vector<double> pulses_needed_as_printed(std::span<const double> frequency_hz, double step_s);
/// Eq. (6.5) as the integral of a frequency that is linear between instants; starts with 0.
std::vector<double> pulses_needed(std::span<const double> frequency_hz, double step_s);

/// One list for the controller, counted from an instant at which the tool is at rest.
struct PulseTrain {
  std::size_t first_instant = 0;  ///< of the demand; the controller's clock is 0 there
  std::size_t last_instant = 0;
  std::vector<std::uint16_t> ticks;  ///< strictly ascending
};

struct PulsePlan {
  std::vector<PulseTrain> trains;  ///< more than one where the controller's limits need it
  double min_drops_per_mm =
      0.0;                       ///< smallest nu / c where material is wanted and the path moves; 0 = nowhere
  std::size_t min_drops_at = 0;  ///< the instant of it
  /// "" or why there is no plan: the limit, and up to where the path must have a stop.
  std::string problem;
  double stop_before_mm = 0.0;  ///< with a problem: a stop before this length would mend it
  /// With a problem: the instants between which there is no stop, and the last one up to which a list would
  /// reach.
  std::size_t problem_from = 0, problem_to = 0, problem_fits = 0;
};

/// Pulses of one path. A path with more entries or time than the limits is cut at its stops; the fraction of
/// a drop that is due goes over into the next list, so that volume is counted over the whole path.
/// @throws std::invalid_argument: check(demand), check(limits), check(setting, limits); flow above
/// max_flow_mm3_s()
PulsePlan plan_pulses(const FlowDemand& demand, const ValveSetting& setting, const ValveLimits& limits);

/// Smallest nu / c of a setting over a demand, as in PulsePlan; +inf when no material is wanted.
double min_drops_per_mm(const FlowDemand& demand, const FlowCurve& curve, std::size_t* at = nullptr);

}  // namespace firn::deposition
