#include "print/simulated/lab_fault.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <sstream>
#include <stdexcept>

#include "config/experiment.h"
#include "files/usage_error.h"
#include "plant/world/setup.h"

namespace firn {
std::vector<LabFault> parse_lab_faults(const std::vector<std::string>& texts, const Experiment& e) {
  std::vector<LabFault> faults;
  const std::span<const std::string_view> ports = plant::world_config(e).kind->ports;
  for (const std::string& text : texts) {
    const auto refuse = [&](const std::string& why) { throw UsageError("--fault \"" + text + "\": " + why); };
    std::istringstream words(text);
    LabFault f;
    std::string kind, rest;
    if (!(words >> f.node_s >> f.fault.port >> kind) || !(f.node_s >= 0.0 && f.node_s < 1e9))
      refuse("wanted is SECONDS PORT KIND [COUNT [DELAY_US]], as \"120 valve_a trip 1\"");
    try {
      f.fault.kind = plant::fault_kind(kind);
    } catch (const std::invalid_argument& error) {
      refuse(error.what());
    }
    if (f.fault.kind == plant::FaultKind::kTrip) f.fault.count = 1;
    if (!words.eof() && (words >> std::ws, !words.eof()) && !(words >> f.fault.count))
      refuse("COUNT is a whole number");
    if (!words.eof() && (words >> std::ws, !words.eof()) && !(words >> f.fault.delay_us))
      refuse("DELAY_US is a whole number");
    if (words >> rest) refuse("\"" + rest + "\" is too much");
    if (std::ranges::find(ports, f.fault.port) == ports.end())
      refuse("the lab has no instrument \"" + f.fault.port + "\"");
    faults.push_back(f);
  }
  std::ranges::stable_sort(faults, {}, &LabFault::node_s);
  return faults;
}

std::string simfault_line(const plant::SimFault& f) {
  return "SIMFAULT " + f.port + " " + std::string(plant::fault_name(f.kind)) + " " + std::to_string(f.count) +
         " " + std::to_string(f.delay_us);
}

}  // namespace firn
