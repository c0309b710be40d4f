#include "config/device_kinds.h"

#include "core/control/python_scheme.h"

namespace firn {

const std::string& device_kind(const Experiment& e, std::string_view node) {
  static const std::string not_given;
  const auto at = e.devices.kind.find(std::string(node));
  return at == e.devices.kind.end() ? not_given : at->second;
}

bool is_python_driver(const Experiment& e, std::string_view node) {
  return control::is_python_scheme(device_kind(e, node));
}

bool has_grbl_stage(const Experiment& e) { return device_kind(e, "stage") == "grbl"; }

bool has_point_scan(const Experiment& e) { return device_kind(e, "laser_profiler") == "lkg"; }

bool has_own_port(const Experiment& e, std::string_view node) {
  for (const DevicePort& port : kDevicePorts)
    if (port.node == node) return is_python_driver(e, node) && e.devices.*port.member == "python:";
  return false;
}

drivers::ScriptOptions script_options(const Experiment& e, std::string_view node, double host_latency_s) {
  const control::PythonScheme scheme = control::parse_python_scheme(device_kind(e, node));
  return {std::string(node), scheme.file_name(),    scheme.class_name,
          scheme.arguments,  has_own_port(e, node), host_latency_s};
}

}  // namespace firn
