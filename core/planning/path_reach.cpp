#include "core/planning/path_reach.h"

#include <utility>

namespace firn::planning {

std::vector<Unreachable> unreachable_paths(const TaskPlanner& planner, const slice::PrintPaths& paths,
                                           const PlanningSetup& setup, std::size_t most) {
  std::vector<Unreachable> out;
  for (const slice::LayerPaths& layer : paths.layers)
    for (const bool measurement : {false, true}) {
      std::vector<PathTask> tasks = tasks_of(paths, layer, measurement, setup);
      for (std::size_t n = 0; n < tasks.size(); ++n) {
        if (out.size() >= most) return out;
        const std::string why = planner.unreachable(tasks[n]);
        if (why.empty()) continue;
        out.push_back({std::move(tasks[n]), "layer " + std::to_string(layer.layer) + ", " +
                                                (measurement ? "measurement" : "deposition") + " path " +
                                                std::to_string(n + 1) + ": " + why});
      }
    }
  return out;
}

std::string refusal(const Unreachable& first) {
  return "a path is out of reach, nothing is printed: " + first.text;
}

}  // namespace firn::planning
