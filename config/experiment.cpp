#include "config/experiment.h"

#include <algorithm>
#include <initializer_list>

namespace firn {
namespace {

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

bool has_two_jets(const Experiment& e) {
  return e.geometry.solid.kind != "none" || e.control.scheme == "registration";
}

bool is_ice(const Experiment& e) { return e.lab.kind == "ice"; }

bool takes_part(const Experiment& e, std::string_view node) {
  if (is_one_of(node,
                {"robot", "valve_a", "valve_b", "laser_point", "heater", "path_planner", "flow_estimator"}))
    return is_ice(e);
  if (is_one_of(node, {"stage", "jet", "jet_b", "laser_profiler", "lamp", "droplet_estimator"}) && is_ice(e))
    return false;
  if (node == "jet_b") return has_two_jets(e);
  if (node == "droplet_estimator") return e.estimator.droplets == "on";
  return true;
}

}  // namespace firn
