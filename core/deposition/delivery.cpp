#include "core/deposition/delivery.h"

#include <algorithm>
#include <cmath>

namespace firn::deposition {
namespace {

struct Places {
  std::vector<double> at_mm;      // of each drop
  std::vector<double> delivered;  // before drop n; one entry more than drops
};

Places places_of(std::span<const Drop> drops, const DemandIntegral& wanted) {
  Places p;
  p.delivered.push_back(0.0);
  for (const Drop& d : drops) {
    p.at_mm.push_back(wanted.length_mm(d.time_s));
    p.delivered.push_back(p.delivered.back() + d.volume_mm3);
  }
  return p;
}

// A window gains a drop only where an end meets one: it suffices to look at windows that begin or end at a
// drop, with the drops on their ends counted (most) and left out (least).
void worst_window(const Places& p, const DemandIntegral& wanted, double window_mm, DeliveryError& error) {
  const double total = wanted.total_length_mm();
  if (!(window_mm > 0.0) || total < window_mm) return;
  const auto look = [&](double from) {
    if (from < 0.0 || from + window_mm > total) return;
    const double slack = 1e-9;
    const auto index = [&](double s) {
      return std::size_t(std::lower_bound(p.at_mm.begin(), p.at_mm.end(), s) - p.at_mm.begin());
    };
    const double volume = wanted.volume_mm3(wanted.time_at_length_s(from + window_mm)) -
                          wanted.volume_mm3(wanted.time_at_length_s(from));
    if (!(volume > 0.0)) return;
    const double most = p.delivered[index(from + window_mm + slack)] - p.delivered[index(from - slack)];
    const double fewest = p.delivered[std::max(index(from + slack), index(from + window_mm - slack))] -
                          p.delivered[index(from + slack)];
    const double ratio = std::max(most / volume - 1.0, 1.0 - fewest / volume);
    if (ratio > error.window_worst) {
      error.window_worst = ratio;
      error.window_from_mm = from;
    }
  };
  look(0.0);
  look(total - window_mm);
  for (double s : p.at_mm) {
    look(s);
    look(s - window_mm);
  }
}

}  // namespace

Granted granted_by(const FlowDemand& demand, const FlowCurve& curve, double tick_s) {
  Granted g{0.0, tick_s};
  for (double q : demand.flow_mm3_s) g.drop_mm3 = std::max(g.drop_mm3, curve.drop_mm3(q));
  return g;
}

std::vector<Drop> drops_of(const PulsePlan& plan, const FlowDemand& demand, const FlowCurve& curve,
                           double tick_s) {
  const DemandIntegral wanted(demand);
  std::vector<Drop> drops;
  for (const PulseTrain& train : plan.trains)
    for (std::uint16_t tick : train.ticks) {
      const double t = demand.step_s * double(train.first_instant) + tick_s * tick;
      drops.push_back({t, curve.drop_mm3(wanted.flow_mm3_s(t))});
    }
  return drops;
}

DeliveryError count_delivery(const FlowDemand& demand, std::span<const Drop> drops, const Granted& granted,
                             double window_mm) {
  const DemandIntegral wanted(demand);
  const Places p = places_of(drops, wanted);
  DeliveryError error;
  error.wanted_mm3 = wanted.total_volume_mm3();
  error.delivered_mm3 = p.delivered.back();
  error.worst_excess_mm3 = -1e300;
  const auto look = [&](double time_s, double delivered) {
    const double off = std::abs(delivered - wanted.volume_mm3(time_s));
    if (off > error.worst_mm3) {
      error.worst_mm3 = off;
      error.worst_at_s = time_s;
    }
    const double tick_mm3 =
        wanted.volume_mm3(time_s + 0.5 * granted.tick_s) - wanted.volume_mm3(time_s - 0.5 * granted.tick_s);
    error.worst_excess_mm3 = std::max(error.worst_excess_mm3, off - 0.5 * granted.drop_mm3 - tick_mm3);
  };
  for (std::size_t n = 0; n < drops.size(); ++n) {
    look(drops[n].time_s, p.delivered[n]);
    look(drops[n].time_s, p.delivered[n + 1]);
    if (n > 0) error.widest_gap_mm = std::max(error.widest_gap_mm, p.at_mm[n] - p.at_mm[n - 1]);
  }
  look(demand.duration_s(), error.delivered_mm3);
  worst_window(p, wanted, window_mm, error);
  return error;
}

}  // namespace firn::deposition
