#include "config/devices.h"

#include <algorithm>
#include <stdexcept>

#include "config/labs.h"

namespace firn {
namespace {

// Instruments of the lab, in its order.
std::vector<std::string> instrument_nodes(const Experiment& e) {
  std::vector<std::string> names;
  for (const LabProcess& p : lab_of(e).processes)
    if (port_defaults(p.node) && (!p.wanted || p.wanted(e))) names.emplace_back(p.node);
  return names;
}

}  // namespace

std::optional<PortDefaults> port_defaults(std::string_view node) {
  for (const DevicePort& port : kDevicePorts)
    if (port.node == node) return port.defaults;
  return std::nullopt;
}

const std::string& port_text(const DevicesConfig& d, std::string_view node) {
  for (const DevicePort& port : kDevicePorts)
    if (port.node == node) return d.*port.member;
  throw std::invalid_argument("'" + std::string(node) + "' is no instrument");
}

std::map<std::string, PortAddress> outside_ports(const Experiment& e) {
  std::map<std::string, PortAddress> outside;
  for (const std::string& node : instrument_nodes(e))
    if (PortAddress a = parse_port_address(port_text(e.devices, node), *port_defaults(node));
        a.kind != PortAddress::Kind::kSimulated)
      outside.emplace(node, std::move(a));
  return outside;
}

std::map<std::string, PortAddress> real_ports(const Experiment& e) {
  auto real = outside_ports(e);
  std::erase_if(real, [](const auto& port) { return !port.second.real(); });
  return real;
}

std::vector<std::string> simulated_ports(const Experiment& e) {
  std::vector<std::string> all = instrument_nodes(e);
  const auto outside = outside_ports(e);
  std::erase_if(all, [&](const std::string& node) { return outside.contains(node); });
  return all;
}

std::string ports_text(const Experiment& e) {
  const auto outside = outside_ports(e);
  std::string text, simulated;
  for (const std::string& node : instrument_nodes(e)) {
    const auto at = outside.find(node);
    const bool real = at != outside.end() && at->second.real();
    std::string& list = real ? text : simulated;
    list += (!list.empty() ? ", " : real ? "REAL: " : "SIMULATED: ") + node;
    if (at != outside.end()) list += " (" + to_text(at->second) + ")";
    if (const auto host = e.hosts.of_node.find(node); host != e.hosts.of_node.end() && !host->second.empty())
      list += " at host " + host->second;
  }
  return text + (text.empty() || simulated.empty() ? "" : "; ") + simulated;
}

}  // namespace firn
