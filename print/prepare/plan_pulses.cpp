#include "print/prepare/plan_pulses.h"

#include <algorithm>
#include <stdexcept>

namespace firn {

deposition::FlowDemand nominal_demand(const Path& path, const motion::PlanResult& result) {
  deposition::FlowDemand demand;
  demand.step_s = result.trajectory.tick_s;
  demand.speed_mm_s = deposition::speeds_at_ticks(result.tool, demand.step_s);
  demand.flow_mm3_s.resize(demand.speed_mm_s.size());
  deposition::nominal_flow(path.width_mm, path.layer_height_mm, demand.speed_mm_s, demand.flow_mm3_s);
  demand.stops = result.stop_samples;
  // two rests within one tick are one
  demand.stops.erase(std::unique(demand.stops.begin(), demand.stops.end()), demand.stops.end());
  std::erase_if(demand.stops, [&](std::size_t n) { return n == 0 || n + 1 >= demand.speed_mm_s.size(); });
  return demand;
}

deposition::PulsePlan nominal_pulses(const InputPath& input, const motion::PlanResult& result,
                                     const ValveConfig& valve) {
  try {
    return deposition::plan_pulses(nominal_demand(input.path, result), valve_setting(valve),
                                   valve_limits(valve));
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(input.place + ": " + e.what());
  }
}

std::vector<AddedStop> add_stops(InputPath& input, const deposition::FlowDemand& demand,
                                 const deposition::PulsePlan& pulses, std::vector<std::size_t>& stops) {
  return motion::insert_stops(
      input.path.points, input.path.closed, input.speed_limit, input.yaw_point_rad,
      {demand.speed_mm_s, demand.step_s, pulses.problem_from, pulses.problem_to, pulses.problem_fits}, stops);
}

}  // namespace firn
