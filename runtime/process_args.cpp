#include "runtime/process_args.h"

#include <charconv>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "core/options/arguments.h"
#include "files/digest.h"
#include "files/record/file.h"
#include "files/run_paths.h"

namespace firn {
namespace {

LossyOptions faults(const std::string& value, NodeId node, std::int32_t incarnation) {
  std::istringstream in(value);
  std::vector<std::string> part;
  for (std::string p; std::getline(in, p, ',');) part.push_back(p);
  if (part.size() != 6)
    refuse_argument("--faults", value, "six numbers: loss,duplicate,reorder,delay,delay_s,seed");
  LossyOptions f;
  double* const probability[] = {&f.loss, &f.duplicate, &f.reorder, &f.delay};
  for (std::size_t n = 0; n < 4; ++n) {
    *probability[n] = argument_number<double>("--faults", part[n]);
    if (!(*probability[n] >= 0.0 && *probability[n] < 1.0)) refuse_argument("--faults", part[n], "in [0, 1)");
  }
  f.delay_s = argument_number<double>("--faults", part[4]);
  if (!(f.delay_s >= 0.0 && f.delay_s <= 10.0)) refuse_argument("--faults", part[4], "in [0, 10] s");
  f.seed = argument_number<std::uint64_t>("--faults", part[5]);
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
  const ProcessArgument table[] = {
      {"--run", &o.run_dir},
      {"--bus", &a.bus_url},
      {"--node", &node},
      {"--control-fd", &o.control_fd},
      {"--epoch-ns", &o.epoch_ns},
      {"--offset-us", &o.offset_us},
      {"--time-scale", &o.time_scale},
      {"--incarnation", &o.incarnation},
      {"--run-id", &o.run_id},
      {"--faults", &fault_text},
      {"--record",
       [&](const std::string& value) {
         if (value != "on") refuse_argument("--record", value, "on");
         o.record = true;
       }},
      {"--blob",
       [&](const std::string& value) {
         const auto at = value.find('=');
         if (at == std::string::npos || at == 0) refuse_argument("--blob", value, "ROLE=SHA256");
         a.blobs.emplace_back(value.substr(0, at), value.substr(at + 1));
       }},
      {"--port",
       [&](const std::string& value) {
         const auto at = value.find('=');
         if (at == std::string::npos || at == 0) refuse_argument("--port", value, "NAME=ADDRESS");
         o.real_ports.insert_or_assign(value.substr(0, at), parse_port_address(value.substr(at + 1)));
       }},
  };
  read_arguments(args, table);
  const NodeInfo* row = find_node(node);
  if (!row) refuse_argument("--node", node, "a node of the channel table");
  o.node = row->id;
  if (o.run_dir.empty()) refuse_argument("--run", "", "the run folder");
  if (!(o.time_scale >= 0.01 && o.time_scale <= 1000.0))
    refuse_argument("--time-scale", exact(o.time_scale), "in [0.01, 1000]");
  if (o.incarnation < 0) refuse_argument("--incarnation", std::to_string(o.incarnation), ">= 0");
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
  if (o.record) {
    args.push_back("--record");
    args.push_back("on");
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

std::string read_text_file(const std::filesystem::path& path) {
  const record::MappedFile file(path, record::MappedFile::Packed::kAsIs);
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

Blobs read_blobs(const ProcessArgs& args) {
  Blobs blobs;
  for (const auto& [role, sha] : args.blobs) {
    const std::filesystem::path path = RunPaths(args.options.run_dir).input_path(sha);
    const record::MappedFile file(path, record::MappedFile::Packed::kAsIs);
    const auto bytes = file.bytes();
    if (sha256_hex(bytes) != sha)
      throw std::runtime_error(path.string() + ": content does not have the SHA-256 of its name (input '" +
                               role + "' was changed)");
    blobs.push_back({role, sha, {bytes.begin(), bytes.end()}});
  }
  return blobs;
}

}  // namespace firn
