// [hosts] and the keys that name a host: which lab files are taken, and their dump.
#include <catch2/catch.hpp>

#include <string>

#include "config/devices.h"
#include "config/error.h"
#include "config/experiment.h"

using namespace firn;

namespace {

Experiment lab_of_text(const std::string& text) { return parse_experiment({{"lab.toml", text}}, {}); }

std::string host_refusal(const std::string& text) {
  try {
    lab_of_text(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "taken";
}

}  // namespace

TEST_CASE("a lab file names hosts of its own and what is at them", "[hosts]") {
  const Experiment e = lab_of_text(
      "[hosts]\nbench = \"me@bench-pc:/opt/firn\"\nattic = \"attic\"\n[devices.jet]\nhost = \"bench\"\n"
      "[nodes.surface_mapper]\nhost = \"attic\"\n");
  CHECK(e.hosts.address.at("bench") == "me@bench-pc:/opt/firn");
  CHECK(e.hosts.of_node.at("jet") == "bench");
  CHECK(e.hosts.of_node.at("surface_mapper") == "attic");
  CHECK(ports_text(e).find("jet at host bench") != std::string::npos);
}

TEST_CASE("a dump with hosts reads back to itself, and one without names none", "[hosts]") {
  const std::string with = dump(lab_of_text("[hosts]\nbench = \"b\"\n[devices.jet]\nhost = \"bench\"\n"));
  CHECK(dump(lab_of_text(with)) == with);
  CHECK(with.find("[hosts]\nbench = \"b\"") != std::string::npos);
  CHECK(dump(lab_of_text("")).find("host = ") == std::string::npos);
  CHECK(dump(lab_of_text("")).find("[hosts") == std::string::npos);
}

TEST_CASE("labs that differ in their hosts are told apart", "[hosts]") {
  const auto differing =
      differences(lab_of_text("[hosts]\nbench = \"b\"\n"), lab_of_text("[hosts]\nattic = \"a\"\n"));
  REQUIRE(differing.size() == 2);
  CHECK(differing[0].key == "hosts.attic");
  CHECK(differing[1].key == "hosts.bench");
}

TEST_CASE("hosts that are none are refused by key", "[hosts]") {
  CHECK(host_refusal("[devices.jet]\nhost = \"bench\"\n").find("devices.jet.host") != std::string::npos);
  CHECK(host_refusal("[devices.jet]\nhost = \"bench\"\n").find("[hosts] has no bench") != std::string::npos);
  CHECK(host_refusal("[nodes.controller]\nhost = \"x\"\n").find("nodes.controller.host") !=
        std::string::npos);
  CHECK(host_refusal("[hosts]\n\"a/b\" = \"x\"\n").find("a-z, 0-9") != std::string::npos);
  CHECK(host_refusal("[hosts]\nbench = \"-oProxyCommand=x\"\n").find("hosts.bench") != std::string::npos);
  CHECK(host_refusal("[hosts]\nbench = \"a b\"\n").find("without blanks") != std::string::npos);
  CHECK(host_refusal("[hosts]\nbench = 3\n").find("must be text") != std::string::npos);
  CHECK(host_refusal("[nodes.safety]\nhost = \"x\"\n").find("unknown key") != std::string::npos);
}

TEST_CASE("a host can be named by --set", "[hosts]") {
  const Experiment e =
      parse_experiment({{"lab.toml", ""}}, {"hosts.bench=me@there", "devices.jet.host=bench"});
  CHECK(e.hosts.address.at("bench") == "me@there");
  CHECK(e.hosts.of_node.at("jet") == "bench");
}
