// Hosts in every kind of lab: which nodes may have one, what comes back from a dump, which file a mistake is
// told of.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "config/devices.h"
#include "config/error.h"
#include "config/experiment.h"
#include "config/include.h"
#include "config/labs.h"
#include "core/grid/random.h"

using namespace firn;

namespace {

constexpr const char* kExperiments[] = {"cuboid.toml", "ice-small.toml",
                                        "aerosol-meander.toml"};  // a kind of lab each

Experiment lab_of_file(const std::string& file, const std::vector<std::string>& overrides = {}) {
  return load_experiment(FIRN_SOURCE_DIR "/experiments/" + file, overrides);
}

std::string mistake_in(const std::string& text) {
  try {
    parse_experiment({{"lab.toml", text}}, {});
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "taken";
}

/// Nodes of an experiment that may have a host.
std::vector<std::string> movable_of(const std::string& file) {
  const Experiment e = lab_of_file(file);
  std::vector<std::string> nodes;
  for (const LabProcess& p : lab_of(e).processes) {
    const bool movable = std::ranges::find(kMovableNodes, p.node) != std::end(kMovableNodes);
    if (movable || port_defaults(p.node)) nodes.emplace_back(p.node);
  }
  return nodes;
}

std::string key_of(const std::string& node) {
  return (port_defaults(node) ? "devices." : "nodes.") + node + ".host";
}

}  // namespace

TEST_CASE("every instrument and every process that may move can have a host, in each kind of lab",
          "[hosts]") {
  for (const std::string file : kExperiments) {
    CHECK(movable_of(file).size() >= 5);
    for (const std::string& node : movable_of(file)) {
      INFO(file << ": " << node);
      const Experiment e = lab_of_file(file, {"hosts.bench=b", key_of(node) + "=bench"});
      CHECK(e.hosts.of_node.at(node) == "bench");
      CHECK(std::ranges::count_if(e.hosts.of_node, [](const auto& at) { return !at.second.empty(); }) == 1);
    }
  }
}

TEST_CASE("scheduler, safety, launcher and recorder stay at the launcher's computer", "[hosts]") {
  for (const char* node : {"scheduler", "safety", "launcher", "recorder"})
    CHECK_THAT(mistake_in("[hosts]\nbench = \"b\"\n[nodes." + std::string(node) + "]\nhost = \"bench\"\n"),
               Catch::Contains("nodes." + std::string(node)));
}

TEST_CASE("hosts of random labs come back from their dump", "[hosts]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const std::string file = kExperiments[random.below(3)];
    std::map<std::string, std::string> addresses, of_node;
    std::vector<std::string> overrides;
    for (std::uint32_t n = 1 + random.below(4); n > 0; --n)
      addresses["h" + std::to_string(random.below(1000))] = "user" + std::to_string(random.below(9)) + "@pc" +
                                                            std::to_string(n) +
                                                            (random.below(2) ? ":/opt/firn" : "");
    for (const auto& [name, address] : addresses) overrides.push_back("hosts." + name + "=" + address);
    for (const std::string& node : movable_of(file)) {
      if (random.below(2) == 0) continue;
      auto host = addresses.begin();
      std::advance(host, random.below(std::uint32_t(addresses.size())));
      of_node[node] = host->first;
      overrides.push_back(key_of(node) + "=" + host->first);
    }
    INFO("seed " << seed << ", " << file);
    const std::string text = dump(lab_of_file(file, overrides));
    const Experiment again = parse_recorded_experiment(text, "dump");
    CHECK(dump(again) == text);
    CHECK(again.hosts.address == addresses);
    for (const auto& [node, host] : again.hosts.of_node) {
      const auto wanted = of_node.find(node);
      CHECK(host == (wanted == of_node.end() ? "" : wanted->second));
    }
  }
}

TEST_CASE("a mistake in a host is told with its file and line", "[hosts]") {
  CHECK_THAT(mistake_in("[hosts]\nbench = \"b\"\n\n[devices.lamp]\nhost = \"attic\"\n"),
             Catch::StartsWith("lab.toml:5: devices.lamp.host = \"attic\""));
  CHECK_THAT(mistake_in("[hosts]\nbench = \"-x\"\n"), Catch::StartsWith("lab.toml:2: hosts.bench = \"-x\""));
}

TEST_CASE("hosts of a lab's file hold until the experiment names others", "[hosts]") {
  const std::string lab = "[hosts]\nbench = \"old\"\nattic = \"a\"\n[devices.lamp]\nhost = \"attic\"\n";
  const Experiment e = parse_experiment({{"lab.toml", lab}, {"part.toml", "[hosts]\nbench = \"new\"\n"}}, {});
  CHECK(e.hosts.address.at("bench") == "new");
  CHECK(e.hosts.address.at("attic") == "a");
  CHECK(e.hosts.of_node.at("lamp") == "attic");
}
