#include "core/deposition/flow_demand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::deposition {

std::vector<double> speeds_at_ticks(std::span<const Point2> tool, double tick_s) {
  const auto step = [&](std::size_t n) {
    const double dx = tool[n + 1].x_mm - tool[n].x_mm, dy = tool[n + 1].y_mm - tool[n].y_mm;
    return std::sqrt(dx * dx + dy * dy) / tick_s;
  };
  std::vector<double> speeds(tool.size(), 0.0);
  for (std::size_t n = 1; n + 1 < tool.size(); ++n) speeds[n] = 0.5 * (step(n - 1) + step(n));
  return speeds;
}

void nominal_flow(double width_mm, double layer_height_mm, std::span<const double> speed_mm_s,
                  std::span<double> flow_mm3_s) {
  const double section_mm2 = width_mm * layer_height_mm;
  for (std::size_t i = 0; i < speed_mm_s.size(); ++i) flow_mm3_s[i] = section_mm2 * speed_mm_s[i];
}

void corrected_flow(std::span<const double> nominal_mm3_s, std::span<const double> action,
                    std::span<double> flow_mm3_s) {
  for (std::size_t i = 0; i < nominal_mm3_s.size(); ++i)
    flow_mm3_s[i] = std::max(0.0, (action[i] + 1.0) * nominal_mm3_s[i]);
}

double action_at(const HeightMap& surface, const Point2& at) {
  const GridSpec& g = surface.spec;
  const double x = (at.x_mm - g.origin_x_mm) / g.pitch_x_mm, y = (at.y_mm - g.origin_y_mm) / g.pitch_y_mm;
  if (!(x >= 0.0 && y >= 0.0 && x <= g.nx - 1 && y <= g.ny - 1)) return 0.0;
  const int i = std::min(int(x), std::max(0, g.nx - 2)), j = std::min(int(y), std::max(0, g.ny - 2));
  const int i1 = std::min(i + 1, g.nx - 1), j1 = std::min(j + 1, g.ny - 1);
  const double fx = x - i, fy = y - j;
  const double low = surface.at(i, j) + fx * (surface.at(i1, j) - surface.at(i, j));
  const double high = surface.at(i, j1) + fx * (surface.at(i1, j1) - surface.at(i, j1));
  const double value = low + fy * (high - low);
  return std::isfinite(value) ? value : 0.0;
}

void check(const FlowDemand& d) {
  if (!std::isfinite(d.step_s) || !(d.step_s > 0.0))
    throw std::invalid_argument("step_s must be finite and above 0");
  if (d.flow_mm3_s.size() != d.speed_mm_s.size())
    throw std::invalid_argument("flow and speed differ in length");
  if (d.flow_mm3_s.size() < 2) throw std::invalid_argument("a path needs at least two instants");
  for (std::size_t i = 0; i < d.flow_mm3_s.size(); ++i)
    for (double v : {d.flow_mm3_s[i], d.speed_mm_s[i]})
      if (!std::isfinite(v) || v < 0.0)
        throw std::invalid_argument("flow or speed at instant " + std::to_string(i) +
                                    " is negative or not finite");
  for (std::size_t n = 0; n < d.stops.size(); ++n)
    if (d.stops[n] == 0 || d.stops[n] + 1 >= d.flow_mm3_s.size() || (n > 0 && d.stops[n] <= d.stops[n - 1]))
      throw std::invalid_argument("stop " + std::to_string(n) + " is not inside the path or does not ascend");
}

Shortfall clip_flow(FlowDemand& demand, double capacity_mm3_s) {
  Shortfall s;
  for (std::size_t i = 0; i < demand.flow_mm3_s.size(); ++i) {
    const double over = demand.flow_mm3_s[i] - capacity_mm3_s;
    if (!(over > 0.0)) continue;
    if (s.instants++ == 0) s.first = i;
    s.volume_mm3 += over * demand.step_s;
    demand.flow_mm3_s[i] = capacity_mm3_s;
  }
  return s;
}

namespace {

std::vector<double> running_sum(const std::vector<double>& rate, double step_s) {
  std::vector<double> sum(rate.size(), 0.0);
  for (std::size_t i = 1; i < rate.size(); ++i) sum[i] = sum[i - 1] + 0.5 * step_s * (rate[i - 1] + rate[i]);
  return sum;
}

}  // namespace

DemandIntegral::DemandIntegral(const FlowDemand& demand)
    : demand_(demand),
      volume_(running_sum(demand.flow_mm3_s, demand.step_s)),
      length_(running_sum(demand.speed_mm_s, demand.step_s)) {}

DemandIntegral::Place DemandIntegral::place(double time_s) const {
  const std::size_t last = volume_.size() - 2;
  if (!(time_s > 0.0)) return {0, 0.0};
  const std::size_t i = std::min(std::size_t(time_s / demand_.step_s), last);
  return {i, std::min(time_s - double(i) * demand_.step_s, demand_.step_s)};
}

double DemandIntegral::value(const std::vector<double>& rate, const std::vector<double>& sum,
                             double time_s) const {
  const auto [i, into] = place(time_s);
  return sum[i] + into * (rate[i] + 0.5 * (rate[i + 1] - rate[i]) * into / demand_.step_s);
}

double DemandIntegral::flow_mm3_s(double time_s) const {
  const auto [i, into] = place(time_s);
  return demand_.flow_mm3_s[i] + (demand_.flow_mm3_s[i + 1] - demand_.flow_mm3_s[i]) * into / demand_.step_s;
}

double DemandIntegral::time_at_length_s(double length_mm) const {
  if (!(length_mm > 0.0)) return 0.0;
  const auto at = std::lower_bound(length_.begin(), length_.end(), length_mm);
  if (at == length_.end()) return demand_.duration_s();
  const std::size_t i = std::size_t(at - length_.begin()) - 1;
  return double(i) * demand_.step_s + time_to_deliver(demand_.speed_mm_s[i], demand_.speed_mm_s[i + 1],
                                                      demand_.step_s, length_mm - length_[i]);
}

double time_to_deliver(double rate0, double rate1, double step_s, double amount) {
  if (!(amount > 0.0)) return 0.0;
  const double change = (rate1 - rate0) / step_s;
  const double root = std::sqrt(std::max(0.0, rate0 * rate0 + 2.0 * change * amount));
  return std::min(
      step_s,
      2.0 * amount / (rate0 + root));  // the form that loses no digits and needs no case for change = 0
}

}  // namespace firn::deposition
