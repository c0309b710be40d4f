// RiseCheck compares the rise of the surface with the droplets of the last layers: a nozzle that is dead,
// blocked or leaking shows in the maps, whatever the pulse counters say.
#pragma once

#include <cstddef>
#include <deque>

#include "config/experiment.h"
#include "core/grid/figure.h"
#include "procs/scheduler/rise_evidence.h"

namespace firn {

/// Tests three hypotheses after each layer. None rests on how far the model says that a droplet spreads: ink
/// is conserved, and wet ink flows.
///   drops without rise: the cells with droplets of one ink rose by less than process.least_rise_share of
///     the rise that the model expects, and by less than that share of the same volume spread evenly over
///     kNear_cells around each droplet; nor did the ink lie within kWide_cells, so far as the maps can tell.
///   rise without drops: the cells rose by more than process.most_rise_share times the expected rise, and so
///     did the sum over all cells within kNear_cells. Or the cells without a droplet within kNear_cells rose
///     by more than least_rise_share of a layer, and the whole map rose by more than the droplets can have
///     given; farther than kFar_cells from every droplet the rise alone is evidence.
///
/// Droplets have given their expected volume times a factor that the print itself shows: its prior is 1 +-
/// kVolume_std, as a lab that is not identified has it, and the layers before those that are judged measure
/// it to kDrift_std.
///
/// A hypothesis is accepted when a share is beyond its limit by kSigmas standard deviations, over the last
/// layer or the last 2, 4 or 8 together: four tests a layer, each wrong once in 40,000 layers, so that a
/// nozzle that is just good enough is stopped at most once in 10,000 layers. A dead nozzle is found as soon
/// as
///   sqrt(I) > kSigmas / least_rise_share
/// for both ways of spreading, I = sum of e^2 / v over the cells, which is 20 to 40 cells away from an edge,
/// in one layer or in two [docs/safety.md].
class RiseCheck {
 public:
  static constexpr double kSigmas = 4.06;     ///< one-sided probability 1 / 40,000
  static constexpr double kVolume_std = 0.3;  ///< of a droplet that was not measured, of the model's
  static constexpr double kDrift_std = 0.1;   ///< between the layers that measured it and those judged
  static constexpr std::size_t kMostLayers = 8;

  using Layer = RiseEvidence::Layer;
  /// Returns the disturbance: its figure is the rise as a share of the expected one, of a leak the rise [um].
  Violation check(const Experiment& experiment, const Layer& layer);
  /// Forgets the last layers: somebody was at the nozzle.
  void restart() { layers_.clear(); }

 private:
  Violation judge(const ProcessConfig& process, const RiseEvidence& sum, std::size_t layers) const;
  bool more_than_fired(const RiseSum& whole, std::size_t layers) const;

  std::deque<RiseEvidence> layers_;  // newest first: those that are judged, and as many before them
};

}  // namespace firn
