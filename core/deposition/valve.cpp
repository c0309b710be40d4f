#include "core/deposition/valve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::deposition {
namespace {

void above_zero(double value, const char* name) {
  if (!std::isfinite(value) || !(value > 0.0))
    throw std::invalid_argument(std::string(name) + " must be finite and above 0");
}

std::vector<MonotoneCurve::Point> flow_to_frequency(const std::vector<FlowCurve::Row>& rows) {
  std::vector<MonotoneCurve::Point> points;
  if (rows.empty() || rows.front().frequency_hz != 0.0 || rows.front().flow_mm3_s != 0.0)
    points.push_back({0.0, 0.0});
  for (const FlowCurve::Row& row : rows) points.push_back({row.flow_mm3_s, row.frequency_hz});
  return points;
}

}  // namespace

void check(const ValveLimits& l) {
  check_options("valve", kValveLimits, l);
  if (l.max_duration_s / l.tick_s > 65536.5)
    throw std::invalid_argument("max_duration_s must be at most 65,536 ticks: entries have 16 bits");
}

FlowCurve::FlowCurve(std::vector<Row> rows) : h_(flow_to_frequency(rows)) {}

FlowCurve FlowCurve::proportional(double hz_per_mm3_s, double max_frequency_hz) {
  if (!kFrequencyPerFlow.holds(hz_per_mm3_s))
    throw std::invalid_argument("hz_per_mm3_s = " + shortest_text(hz_per_mm3_s) + " is outside " +
                                text(kFrequencyPerFlow));
  above_zero(max_frequency_hz, "max_frequency_hz");
  return FlowCurve({{max_frequency_hz, max_frequency_hz / hz_per_mm3_s}});
}

double FlowCurve::drop_mm3(double flow_mm3_s) const {
  const double frequency = frequency_hz(flow_mm3_s);
  return frequency > 0.0 ? std::min(flow_mm3_s, h_.points().back().x) / frequency : 1.0 / h_.slope_at_start();
}

void check(const ValveSetting& setting, const ValveLimits& limits) {
  check_options("valve", OptionTable{kValvePulse}, setting);
  if (setting.pulse_s < limits.min_pulse_s)
    throw std::invalid_argument("pulse_s = " + std::to_string(setting.pulse_s) +
                                " is below the valve's minimum of " + std::to_string(limits.min_pulse_s) +
                                " s");
}

double max_frequency_hz(const ValveSetting& setting, const ValveLimits& limits) {
  return std::min({1.0 / setting.pulse_s, 1.0 / limits.tick_s, limits.max_frequency_hz,
                   setting.curve.max_frequency_hz()});
}

double max_flow_mm3_s(const ValveSetting& setting, const ValveLimits& limits) {
  return std::min(setting.curve.flow_mm3_s(max_frequency_hz(setting, limits)), limits.max_flow_mm3_s);
}

}  // namespace firn::deposition
