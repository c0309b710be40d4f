#include "procs/scheduler/rise_check.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace firn {
namespace {

std::string um(double mm) { return std::to_string(mm * 1e3) + " um"; }

bool without_rise(const RiseEvidence::Ink& ink, double least) {
  constexpr double kSigmas = RiseCheck::kSigmas;
  return ink.own.below(least, kSigmas) && ink.spread.below(least, kSigmas) && ink.wide.below(least, 0.0);
}

}  // namespace

bool RiseCheck::more_than_fired(const RiseSum& whole, std::size_t layers) const {
  double weight = 1.0 / (kVolume_std * kVolume_std), factor = weight;
  RiseSum before;
  for (std::size_t n = layers; n < std::min(layers_.size(), layers + kMostLayers); ++n)
    before.add(layers_[n].whole);
  if (const double e = before.expected_mm; e > 0.0) {
    const double seen = 1.0 / (before.variance_mm2 / (e * e) + kDrift_std * kDrift_std);
    factor += seen * before.measured_mm / e;
    weight += seen;
  }
  factor /= weight;
  const double excess_mm = whole.measured_mm - factor * whole.expected_mm;
  return excess_mm > kSigmas * std::sqrt(whole.variance_mm2 + whole.expected_mm * whole.expected_mm / weight);
}

Violation RiseCheck::judge(const ProcessConfig& process, const RiseEvidence& sum, std::size_t layers) const {
  const double least = process.least_rise_share, most = process.most_rise_share;
  const std::string where = layers == 1 ? "" : "in the last " + std::to_string(layers) + " layers ";
  for (const std::size_t n : {0, 1}) {
    const RiseEvidence::Ink& ink = sum.inks[n];
    if (ink.own.cells == 0.0) continue;
    const auto told = [&](const char* which, const RiseSum& r) {
      return std::string(n ? "jet_b: " : "jet: ") + where + std::to_string(int(r.cells)) + " cells " + which +
             " its droplets rose by " + um(r.measured_mm / r.cells) + " on average, " +
             um(r.expected_mm / r.cells) + " is expected: ";
    };
    const RiseSum &own = ink.own, &reach = ink.reach;
    if (least > 0.0 && without_rise(ink, least))
      return {told("with", own) + "drops without rise, the nozzle is dead",
              {own.measured_mm / own.expected_mm, least, "", "process.least_rise_share"}};
    if (ink.much.above(most, kSigmas) && reach.sum_above(most, kSigmas))
      return {told("near", reach) + "rise without drops, it gives too much",
              {reach.measured_mm / reach.expected_mm, most, "", "process.most_rise_share"}};
  }
  const auto leaks = [&](const RiseSum& cells) { return least > 0.0 && cells.above(least, kSigmas); };
  const bool far = leaks(sum.far);
  if (!far && !(leaks(sum.bare) && more_than_fired(sum.whole, layers))) return {};
  const RiseSum& cells = far ? sum.far : sum.bare;
  return {where + std::to_string(int(cells.cells)) + " cells without a droplet near rose by " +
              um(cells.measured_mm / cells.cells) + " on average: rise without drops, a nozzle leaks",
          {cells.measured_mm / cells.cells * 1e3, least * cells.expected_mm / cells.cells * 1e3, "um",
           "process.least_rise_share"}};
}

Violation RiseCheck::check(const Experiment& e, const Layer& layer) {
  if (layer.before.spec != layer.drops.spec || layer.after.spec != layer.drops.spec) return {};
  layers_.push_front(RiseEvidence(e, layer));
  if (layers_.size() > 2 * kMostLayers) layers_.pop_back();
  RiseEvidence sum;
  for (std::size_t n = 1; n <= std::min(layers_.size(), kMostLayers); ++n) {
    sum.add(layers_[n - 1]);
    if ((n & (n - 1)) != 0) continue;  // 1, 2, 4, 8
    if (Violation what = judge(e.process, sum, n); !what.empty()) return what;
  }
  return {};
}

}  // namespace firn
