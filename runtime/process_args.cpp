#include "runtime/process_args.h"

#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "files/digest.h"

namespace firn {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& value, const std::string& must) {
  throw std::invalid_argument(name + " '" + value + "': must be " + must);
}

template <class T>
T number(const std::string& name, const std::string& value) {
  T v{};
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), v);
  if (error != std::errc{} || end != value.data() + value.size()) refuse(name, value, "a number");
  return v;
}

LossyOptions faults(const std::string& value, NodeId node, std::int32_t incarnation) {
  std::istringstream in(value);
  std::vector<std::string> part;
  for (std::string p; std::getline(in, p, ',');) part.push_back(p);
  if (part.size() != 6) refuse("--faults", value, "six numbers: loss,duplicate,reorder,delay,delay_s,seed");
  LossyOptions f;
  double* const probability[] = {&f.loss, &f.duplicate, &f.reorder, &f.delay};
  for (std::size_t n = 0; n < 4; ++n) {
    *probability[n] = number<double>("--faults", part[n]);
    if (!(*probability[n] >= 0.0 && *probability[n] < 1.0)) refuse("--faults", part[n], "in [0, 1)");
  }
  f.delay_s = number<double>("--faults", part[4]);
  if (!(f.delay_s >= 0.0 && f.delay_s <= 10.0)) refuse("--faults", part[4], "in [0, 10] s");
  f.seed = number<std::uint64_t>("--faults", part[5]);
  f.node = std::uint32_t(node);
  f.incarnation = std::uint32_t(incarnation);
  return f;
}

std::string exact(double v) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, v).ptr};
}

}  // namespace

ProcessArgs parse_process_args(const std::vector<std::string>& args) {
  ProcessArgs a;
  ProcessOptions& o = a.options;
  std::string node, fault_text;
  for (std::size_t n = 0; n < args.size(); n += 2) {
    const std::string& name = args[n];
    if (n + 1 == args.size()) refuse(name, "", "followed by its value");
    const std::string& value = args[n + 1];
    if (name == "--run")
      o.run_dir = value;
    else if (name == "--bus")
      a.bus_url = value;
    else if (name == "--node")
      node = value;
    else if (name == "--control-fd")
      o.control_fd = number<int>(name, value);
    else if (name == "--epoch-ns")
      o.epoch_ns = number<std::int64_t>(name, value);
    else if (name == "--offset-us")
      o.offset_us = number<std::int64_t>(name, value);
    else if (name == "--time-scale")
      o.time_scale = number<double>(name, value);
    else if (name == "--incarnation")
      o.incarnation = number<std::int32_t>(name, value);
    else if (name == "--run-id")
      o.run_id = number<std::int64_t>(name, value);
    else if (name == "--faults")
      fault_text = value;
    else if (name == "--blob") {
      const auto at = value.find('=');
      if (at == std::string::npos || at == 0) refuse(name, value, "ROLE=SHA256");
      a.blobs.emplace_back(value.substr(0, at), value.substr(at + 1));
    } else if (name == "--port") {
      const auto at = value.find('=');
      if (at == std::string::npos || at == 0) refuse(name, value, "NAME=ADDRESS");
      o.real_ports.insert_or_assign(value.substr(0, at), parse_port_address(value.substr(at + 1)));
    } else
      refuse(name, value, "an argument of a process of Firn; firn print starts these");
  }
  const NodeInfo* row = find_node(node);
  if (!row) refuse("--node", node, "a node of the channel table");
  o.node = row->id;
  if (o.run_dir.empty()) refuse("--run", "", "the run folder");
  if (!(o.time_scale >= 0.01 && o.time_scale <= 1000.0))
    refuse("--time-scale", exact(o.time_scale), "in [0.01, 1000]");
  if (o.incarnation < 0) refuse("--incarnation", std::to_string(o.incarnation), ">= 0");
  if (!fault_text.empty()) o.faults = faults(fault_text, o.node, o.incarnation);
  return a;
}

std::vector<std::string> to_arguments(const ProcessArgs& a) {
  const ProcessOptions& o = a.options;
  std::vector<std::string> args{"--run",         o.run_dir,
                                "--bus",         a.bus_url,
                                "--node",        std::string(info(o.node).name),
                                "--control-fd",  std::to_string(o.control_fd),
                                "--epoch-ns",    std::to_string(o.epoch_ns),
                                "--offset-us",   std::to_string(o.offset_us),
                                "--time-scale",  exact(o.time_scale),
                                "--incarnation", std::to_string(o.incarnation),
                                "--run-id",      std::to_string(o.run_id)};
  const LossyOptions& f = o.faults;
  if (f.any()) {
    args.push_back("--faults");
    args.push_back(exact(f.loss) + "," + exact(f.duplicate) + "," + exact(f.reorder) + "," + exact(f.delay) +
                   "," + exact(f.delay_s) + "," + std::to_string(f.seed));
  }
  for (const auto& [port, address] : o.real_ports) {
    args.push_back("--port");
    args.push_back(port + "=" + to_text(address));
  }
  for (const auto& [role, sha] : a.blobs) {
    args.push_back("--blob");
    args.push_back(role + "=" + sha);
  }
  return args;
}

std::string read_text_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": " + std::strerror(errno));
  return {std::istreambuf_iterator<char>(in), {}};
}

Blobs read_blobs(const ProcessArgs& args) {
  Blobs blobs;
  for (const auto& [role, sha] : args.blobs) {
    const std::string path = args.options.run_dir + "/inputs/" + sha;
    const std::string text = read_text_file(path);
    const auto bytes = std::as_bytes(std::span(text));
    if (sha256_hex(bytes) != sha)
      throw std::runtime_error(path + ": content does not have the SHA-256 of its name (input '" + role +
                               "' was changed)");
    blobs.push_back({role, sha, {bytes.begin(), bytes.end()}});
  }
  return blobs;
}

}  // namespace firn
