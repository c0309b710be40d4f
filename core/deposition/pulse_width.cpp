#include "core/deposition/pulse_width.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firn::deposition {

WidthModulation ideal_width_modulation(double open_flow_mm3_s, double period_s, const ValveLimits& limits) {
  return {period_s,
          MonotoneCurve({{limits.min_pulse_s, open_flow_mm3_s * limits.min_pulse_s},
                         {period_s, open_flow_mm3_s * period_s}}),
          false};
}

void check(const WidthModulation& m, const ValveLimits& limits) {
  if (!std::isfinite(m.period_s) || m.period_s < limits.tick_s)
    throw std::invalid_argument("period_s must be at least one tick");
  const MonotoneCurve::Point narrow = m.dose.points().front(), wide = m.dose.points().back();
  if (narrow.x < limits.min_pulse_s || wide.x > m.period_s * (1.0 + 1e-12))
    throw std::invalid_argument("the dose table must lie between min_pulse_s and period_s");
  if (!(narrow.y > 0.0)) throw std::invalid_argument("the narrowest pulse must deliver something");
}

std::vector<WidthPulse> plan_widths(const FlowDemand& demand, const WidthModulation& m,
                                    const ValveLimits& limits) {
  check(demand);
  check(m, limits);
  const DemandIntegral wanted(demand);
  const double least = m.dose.points().front().y;
  std::vector<WidthPulse> pulses;
  double due = 0.0;
  const std::size_t periods = std::size_t(std::ceil(demand.duration_s() / m.period_s - 1e-9));
  for (std::size_t k = 0; k < periods; ++k) {
    const double begin = m.period_s * double(k), end = std::min(begin + m.period_s, demand.duration_s());
    const double want = wanted.volume_mm3(end) - wanted.volume_mm3(begin) + (m.carry ? due : 0.0);
    WidthPulse pulse{0.5 * (begin + end), 0.0, 0.0};
    if (want >= 0.5 * least) {  // nearer to the narrowest pulse than to none
      pulse.width_s = m.dose.inverse(want);
      pulse.dose_mm3 = m.dose.at(pulse.width_s);
      pulses.push_back(pulse);
    }
    due = want - pulse.dose_mm3;
  }
  return pulses;
}

std::vector<Drop> drops_of(std::span<const WidthPulse> pulses) {
  std::vector<Drop> drops;
  for (const WidthPulse& p : pulses) drops.push_back({p.centre_s, p.dose_mm3});
  return drops;
}

}  // namespace firn::deposition
