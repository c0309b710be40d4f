#include "config/experiment.h"

#include <algorithm>
#include <initializer_list>

namespace firn {

bool has_two_jets(const Experiment& e) {
  return e.geometry.solid.kind != "none" || e.control.scheme == "registration";
}

bool takes_part(const Experiment& e, std::string_view node) {
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) { return std::ranges::find(names, node) != names.end(); };
  const bool ice = e.lab.kind == "ice";
  if (node == "jet_b") return !ice && has_two_jets(e);
  if (node == "droplet_estimator") return !ice && e.estimator.droplets == "on";
  if (is_one_of({"stage", "jet", "laser_profiler", "lamp"})) return !ice;
  if (is_one_of({"robot", "valve_a", "valve_b", "laser_point", "heater", "path_planner", "flow_estimator"})) return ice;
  return true;
}

}  // namespace firn
