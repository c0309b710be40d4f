#include <algorithm>
#include <cmath>

#include "core/motion/aerosol/measure.h"
#include "core/motion/aerosol/plan.h"

namespace firn::motion {

PlaneState state_at(const AerosolPlan& plan, double t_s) {
  if (plan.pieces.empty()) return {};
  const auto after = std::ranges::upper_bound(plan.pieces, t_s, {}, &Piece::t_s);
  const Piece& piece = after == plan.pieces.begin() ? *after : *(after - 1);
  return state_of(piece, std::clamp(t_s - piece.t_s, 0.0, piece.duration_s));
}

Trajectory sample_stage(const AerosolPlan& plan, const AerosolMachine& machine) {
  Trajectory out;
  out.tick_s = machine.tick_s;
  out.axes = 2;
  out.axis_units = {"mm", "mm"};
  const double sign = machine.substrate_moves ? -1.0 : 1.0;
  const double duration = plan.duration_s();
  const std::size_t last = std::size_t(std::ceil(duration / machine.tick_s - 1e-9));
  if (!plan.pieces.empty()) out.positions.reserve(2 * (last + 1));
  for (std::size_t n = 0; n <= last && !plan.pieces.empty(); ++n) {
    const Point2 p = state_at(plan, std::min(double(n) * machine.tick_s, duration)).p_mm;
    out.positions.push_back(machine.stage_origin.x_mm + sign * p.x_mm);
    out.positions.push_back(machine.stage_origin.y_mm + sign * p.y_mm);
  }
  const AerosolReport& r = plan.report;
  out.certificate.limits = {
      {"axis speed", r.axis_speed_ratio.value, r.axis_speed_ratio.t_s},
      {"axis acceleration", r.axis_acceleration_ratio.value, r.axis_acceleration_ratio.t_s}};
  out.certificate.duration_s = duration;
  out.certificate.lower_bound_s = r.lower_bound_s;
  return out;
}

std::vector<ShutterCommand> shutter_commands(const AerosolPlan& plan, const AerosolMachine& machine) {
  std::vector<ShutterCommand> commands;
  for (const ShutterSpan& span : plan.open) {
    commands.push_back({span.open_s - machine.shutter_delay_s, true});
    commands.push_back({span.close_s - machine.shutter_delay_s, false});
  }
  return commands;
}

}  // namespace firn::motion
