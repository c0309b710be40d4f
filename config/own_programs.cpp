#include "config/own_programs.h"

#include <algorithm>
#include <iterator>

namespace firn {
namespace {

constexpr std::size_t kLongestName = 24;  // a channel of LCM, own/NAME/CHANNEL, has 63 bytes
constexpr std::string_view kSource = "own:";

// Whoever reads a log must not take such a program for one of these.
constexpr std::string_view kTaken[] = {"scheduler",
                                       "surface_mapper",
                                       "controller",
                                       "stage",
                                       "jet",
                                       "jet_b",
                                       "laser_profiler",
                                       "lamp",
                                       "safety",
                                       "robot",
                                       "laser_point",
                                       "heater",
                                       "path_planner",
                                       "droplet_estimator",
                                       "camera",
                                       "gas",
                                       "droplet_watch",
                                       "flow_estimator",
                                       "valve_a",
                                       "valve_b",
                                       "recorder",
                                       "launcher",
                                       "world",
                                       "relay",
                                       "page",
                                       "operator",
                                       "firn"};

}  // namespace

bool is_own_name(std::string_view name) {
  const auto is_allowed = [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, is_allowed) &&
         std::ranges::find(kTaken, name) == std::end(kTaken);
}

std::string_view own_source(std::string_view value) {
  return value.starts_with(kSource) ? value.substr(kSource.size()) : std::string_view();
}

}  // namespace firn
