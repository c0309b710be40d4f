#include "core/deposition/pulses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace firn::deposition {
namespace {

// An interval between two ticks of the controller, on which flow and drop size are linear.
struct LinearSpan {
  double begin_s, length_s, flow0, flow1, drop0, drop1;
  double flow_at(double into_s) const { return flow0 + (flow1 - flow0) * into_s / length_s; }
  double drop_at(double into_s) const { return drop0 + (drop1 - drop0) * into_s / length_s; }
  double volume_until(double into_s) const { return 0.5 * into_s * (flow0 + flow_at(into_s)); }
};

// Eqs. (6.5), (6.6) in volumes: a drop is due when the wanted volume leads the delivered one by half a drop.
class DropCounter {
 public:
  DropCounter(const FlowCurve& curve, double tick_s) : curve_(curve), tick_s_(tick_s) {}

  void advance(const LinearSpan& s) {
    const double swelling =
        (s.drop1 - s.drop0) / s.length_s;  // the threshold moves with the size of the drop
    for (double into = 0.0;;) {
      const auto lead = [&](double at) {
        return wanted_mm3_ + s.volume_until(at) - delivered_mm3_ - 0.5 * s.drop_at(at);
      };
      if (!(lead(s.length_s) > 0.0)) break;
      const double rate = s.flow_at(into) - 0.5 * swelling, missing = -lead(into);
      if (missing > 0.0) {
        const double change = (s.flow1 - s.flow0) / s.length_s;
        const double root = std::sqrt(std::max(0.0, rate * rate + 2.0 * change * missing));
        into = rate + root > 0.0 ? std::min(s.length_s, into + 2.0 * missing / (rate + root)) : s.length_s;
      }
      const double t = s.begin_s + into, fired_s = tick_s_ * std::floor(t / tick_s_ + 0.5);
      delivered_mm3_ += curve_.drop_mm3(std::max(0.0, s.flow_at(fired_s - s.begin_s)));
      instants.push_back(t);
    }
    wanted_mm3_ += s.volume_until(s.length_s);
  }

  std::vector<double> instants;

 private:
  const FlowCurve& curve_;
  double tick_s_, wanted_mm3_ = 0.0, delivered_mm3_ = 0.0;
};

// h is evaluated at every tick of the controller, so that its bend between two instants counts.
std::vector<double> instants_of(const FlowDemand& d, const FlowCurve& curve, double tick_s) {
  const int parts = std::max(1, int(std::ceil(d.step_s / tick_s - 1e-9)));
  const double part_s = d.step_s / parts;
  DropCounter counter(curve, tick_s);
  double flow0 = d.flow_mm3_s[0], drop0 = curve.drop_mm3(flow0);
  for (std::size_t i = 0; i + 1 < d.flow_mm3_s.size(); ++i) {
    const double first = d.flow_mm3_s[i], change = d.flow_mm3_s[i + 1] - first;
    for (int p = 1; p <= parts; ++p) {
      const double flow1 = p == parts ? d.flow_mm3_s[i + 1] : first + change * p / parts,
                   drop1 = curve.drop_mm3(flow1);
      counter.advance({d.step_s * double(i) + part_s * (p - 1), part_s, flow0, flow1, drop0, drop1});
      flow0 = flow1;
      drop0 = drop1;
    }
  }
  return std::move(counter.instants);
}

std::vector<std::uint16_t> to_ticks(std::span<const double> instants_s, double start_s, double tick_s) {
  std::vector<std::uint16_t> ticks;
  ticks.reserve(instants_s.size());
  std::int64_t before = -1;
  for (double t : instants_s) {
    // One pulse per tick is the fastest: rounding then keeps the order, and max() only mends the last bit.
    const std::int64_t tick = std::max(before + 1, std::int64_t(std::floor((t - start_s) / tick_s + 0.5)));
    before = std::min<std::int64_t>(tick, 65535);
    ticks.push_back(std::uint16_t(before));
  }
  return ticks;
}

// Length of the path up to an instant.
double length_at_mm(const FlowDemand& d, std::size_t instant) {
  double s = 0.0;
  for (std::size_t i = 0; i < instant; ++i) s += 0.5 * d.step_s * (d.speed_mm_s[i] + d.speed_mm_s[i + 1]);
  return s;
}

}  // namespace

std::vector<double> pulses_needed_as_printed(std::span<const double> frequency_hz, double step_s) {
  std::vector<double> needed;
  double sum = 0.0;
  for (double nu : frequency_hz) needed.push_back(step_s * (sum += nu));
  return needed;
}

std::vector<double> pulses_needed(std::span<const double> frequency_hz, double step_s) {
  std::vector<double> needed(frequency_hz.size(), 0.0);
  for (std::size_t i = 1; i < needed.size(); ++i)
    needed[i] = needed[i - 1] + 0.5 * step_s * (frequency_hz[i - 1] + frequency_hz[i]);
  return needed;
}

double min_drops_per_mm(const FlowDemand& d, const FlowCurve& curve, std::size_t* at) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < d.flow_mm3_s.size(); ++i) {
    if (!(d.flow_mm3_s[i] > 0.0) || !(d.speed_mm_s[i] > 0.0)) continue;
    const double per_mm = curve.frequency_hz(d.flow_mm3_s[i]) / d.speed_mm_s[i];
    if (!(per_mm < least)) continue;
    least = per_mm;
    if (at) *at = i;
  }
  return least;
}

PulsePlan plan_pulses(const FlowDemand& demand, const ValveSetting& setting, const ValveLimits& limits) {
  check(demand);
  check(limits);
  check(setting, limits);
  const double capacity = max_flow_mm3_s(setting, limits) * (1.0 + 1e-12);
  for (std::size_t i = 0; i < demand.flow_mm3_s.size(); ++i)
    if (demand.flow_mm3_s[i] > capacity)
      throw std::invalid_argument("flow at instant " + std::to_string(i) + " is " +
                                  std::to_string(demand.flow_mm3_s[i]) + " mm3/s, above the valve's " +
                                  std::to_string(capacity) + " mm3/s");
  PulsePlan plan;
  const double least = min_drops_per_mm(demand, setting.curve, &plan.min_drops_at);
  plan.min_drops_per_mm = std::isfinite(least) ? least : 0.0;

  const std::vector<double> instants = instants_of(demand, setting.curve, limits.tick_s);
  std::vector<std::size_t> ends = demand.stops;
  ends.push_back(demand.flow_mm3_s.size() - 1);
  const auto first_pulse_from = [&](std::size_t instant) {
    return std::size_t(std::lower_bound(instants.begin(), instants.end(), demand.step_s * double(instant)) -
                       instants.begin());
  };
  const std::size_t longest = std::size_t(limits.max_duration_s / demand.step_s * (1.0 + 1e-12));  // in steps
  for (std::size_t begin = 0, e = 0; e < ends.size();) {
    const std::size_t pulse = first_pulse_from(begin);
    const auto fits = [&](std::size_t end) {
      const std::size_t behind = end == ends.back() ? instants.size() : first_pulse_from(end);
      return end - begin <= longest && behind - pulse <= std::size_t(limits.max_entries);
    };
    if (!fits(ends[e])) {
      std::size_t last = begin;
      for (std::size_t far = ends[e]; far - last > 1;) {  // the last instant that would fit
        const std::size_t middle = last + (far - last) / 2;
        (fits(middle) ? last : far) = middle;
      }
      plan.trains.clear();
      plan.problem_from = begin;
      plan.problem_to = ends[e];
      plan.problem_fits = last;
      plan.stop_before_mm = length_at_mm(demand, last);
      plan.problem = "the path does not stop between " + std::to_string(length_at_mm(demand, begin)) +
                     " and " + std::to_string(length_at_mm(demand, ends[e])) +
                     " mm: above the controller's limit of " +
                     (ends[e] - begin > longest ? std::to_string(limits.max_duration_s) + " s"
                                                : std::to_string(limits.max_entries) + " entries") +
                     "; it needs a stop before " + std::to_string(plan.stop_before_mm) + " mm";
      return plan;
    }
    while (e + 1 < ends.size() && fits(ends[e + 1])) ++e;
    const std::size_t behind = e + 1 == ends.size() ? instants.size() : first_pulse_from(ends[e]);
    plan.trains.push_back({begin, ends[e],
                           to_ticks(std::span(instants).subspan(pulse, behind - pulse),
                                    demand.step_s * double(begin), limits.tick_s)});
    begin = ends[e++];
  }
  return plan;
}

}  // namespace firn::deposition
