#include "procs/relay/hello.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "files/json.h"
#include "files/run_paths.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"

namespace firn::relay {
namespace {

using nlohmann::json;

json json_of(const HostFacts& f) {
  return {{"protocol", f.protocol}, {"version", f.version}, {"commit", f.commit},   {"sources", f.sources},
          {"platform", f.platform}, {"results", f.results}, {"boot_id", f.boot_id}, {"host", f.host}};
}

json json_of(const std::map<std::string, FileState>& files) {
  json j = json::object();
  for (const auto& [name, state] : files) j[name] = {state.bytes, state.sha256};
  return j;
}

json json_of(const HostOrder& o) {
  return {{"name", o.name},
          {"address", o.address},
          {"program", o.program},
          {"run_id", o.run_id},
          {"run", o.run},
          {"place", o.place},
          {"nodes", o.nodes},
          {"arguments", o.arguments},
          {"files", json_of(o.files)},
          {"slack_ms", o.slack_ms},
          {"silence_s", o.silence_s},
          {"simulated", o.simulated},
          {"collect", o.collect}};
}

HostFacts facts_of(const json& j) {
  return {j.at("protocol"), j.at("version"), j.at("commit"),  j.at("sources"),
          j.at("platform"), j.at("results"), j.at("boot_id"), j.at("host")};
}

std::map<std::string, FileState> files_of(const json& j) {
  std::map<std::string, FileState> files;
  for (const auto& [name, state] : j.items()) files[name] = {state.at(0), state.at(1)};
  return files;
}

HostOrder order_of(const json& j) {
  HostOrder o;
  j.at("name").get_to(o.name);
  j.at("address").get_to(o.address);
  j.at("program").get_to(o.program);
  j.at("run_id").get_to(o.run_id);
  j.at("run").get_to(o.run);
  j.at("place").get_to(o.place);
  j.at("nodes").get_to(o.nodes);
  j.at("arguments").get_to(o.arguments);
  o.files = files_of(j.at("files"));
  j.at("slack_ms").get_to(o.slack_ms);
  j.at("silence_s").get_to(o.silence_s);
  j.at("simulated").get_to(o.simulated);
  j.at("collect").get_to(o.collect);
  return o;
}

template <class Read>
auto read_json(const std::string& text, Read read) try {
  return read(json::parse(text));
} catch (const json::exception& e) {
  throw std::invalid_argument(std::string("hello: ") + e.what());
}

}  // namespace

HostPlace place_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  return {text.substr(0, colon), colon == text.npos ? "firn" : text.substr(colon + 1)};
}

HostFacts own_facts() {
  HostFacts f;
  f.version = build_version();
  f.commit = build_commit();
  f.sources = build_sources();
  f.platform = platform_description();
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx",
                static_cast<unsigned long long>(digest_of(result_fingerprint())));
  f.results = digits;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> f.boot_id;
  char name[256] = {};
  ::gethostname(name, sizeof name - 1);
  f.host = name;
  return f;
}

std::string unlike(const HostFacts& launcher, const HostFacts& host) {
  if (launcher.protocol != host.protocol || launcher.sources != host.sources)
    return "has another build of firn: " + host.version + " (" + host.commit + "), here " + launcher.version +
           " (" + launcher.commit + "); firn host --install LAB copies this one there";
  return "";
}

std::string to_json(const HostOrder& order) { return json_of(order).dump(); }
HostOrder order_from_json(const std::string& text) {
  return read_json(text, [](const json& j) { return order_of(j); });
}

std::string to_json(const Hello& h) {
  return json{{"facts", json_of(h.facts)}, {"order", json_of(h.order)}, {"wants", h.wants}, {"lane", h.lane}}
      .dump();
}
Hello hello_from_json(const std::string& text) {
  return read_json(text, [](const json& j) {
    return Hello{facts_of(j.at("facts")), order_of(j.at("order")),
                 j.at("wants").get<std::vector<std::string>>(), j.at("lane").get<std::string>()};
  });
}

std::string to_json(const std::map<std::string, FileState>& files) { return json_of(files).dump(); }
std::map<std::string, FileState> files_from_json(const std::string& text) {
  return read_json(text, [](const json& j) { return files_of(j); });
}

std::vector<std::string> grown_by(const std::string& node) {
  return {RunPaths::wal_name(node), std::string(RunPaths::kNodes) + "/" + node + ".err",
          "cassettes/" + node + ".cassette"};
}

std::string faults_of(const std::string& node) {
  return std::string(RunPaths::kNodes) + "/" + node + ".faults";
}

bool is_made_by(const std::vector<std::string>& nodes, std::string_view name) {
  return std::ranges::any_of(nodes, [&](const std::string& node) {
    const auto grown = grown_by(node);
    return std::ranges::find(grown, name) != grown.end() || name == faults_of(node);
  });
}

}  // namespace firn::relay
