// Real instruments at another computer: bring-up, identity, and a print on them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "files/json.h"
#include "print/bringup/far_instruments.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "tests/cli/run_firn.h"
#include "tests/live/far_hosts.h"
#include "tests/live/hardware.h"
#include "tests/live/live_checks.h"
#include "tests/live/no_hosts.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

/// Jet and lamp at serial lines of the host "attic", stage and profiler at TCP ports of this computer.
struct FarInstruments {
  explicit FarInstruments(std::uint64_t seed) : hosts({"attic"}), simulated(part(seed)), hardware(simulated) {
    e = simulated;
    hardware.connect(e);
    e.hosts.address["attic"] = "attic:" FIRN_BINARY_DIR "/bin/firn";
    e.hosts.of_node["jet"] = e.hosts.of_node["lamp"] = "attic";
  }
  static Experiment part(std::uint64_t seed) {
    Experiment e = tiny_part(seed);
    e.run.time_scale = 1.0;
    e.part.shape.height_mm = 0.012;
    e.process.scan_speed_mm_s = 15.0;
    return e;
  }
  FarHosts hosts;
  Experiment simulated;
  Hardware hardware;
  Experiment e;
};

std::string identities_refused(const Experiment& e, const BringupState& state) {
  return identity_refusal(full_product(), e, ".", state, "lab.bringup.json", {}, [] { return false; });
}

}  // namespace

TEST_CASE("instruments at another computer are brought up, known again and printed with", "[hosts]") {
  if (no_hosts()) return;
  FarInstruments lab(81);
  const TempFolder folder;
  const std::string file = (folder.path() / "lab.toml").string();
  std::ofstream(file) << dump(lab.e);
  const Said said = firn_says({"bringup", file, "--row", "0", "--json"});
  INFO(said.out << said.err);
  CHECK(said.code == 0);
  const BringupState state = bringup_state_in(said.out);
  for (const char* node : {"stage", "jet", "laser_profiler", "lamp"}) {
    INFO(node);
    const auto row = std::ranges::find(state.rows, node, &BringupResult::node);
    REQUIRE(row != state.rows.end());
    CHECK(row->state == "ok");
    CHECK(row->port == port_of(lab.e, node));
    CHECK(state.identities.contains(node));
  }
  CHECK(identities_refused(lab.e, state).empty());
  BringupState other = state;
  other.identities["lamp"] = "another lamp";
  CHECK_THAT(identities_refused(lab.e, other), Contains("another instrument is at") && Contains("lamp"));

  LiveRun run(lab.e);
  run.start(false);
  INFO(run.path());
  CHECK(status_of(run) == 0);
  CHECK_THAT(run.said(), Contains("lamp (serial:") && Contains("at host attic"));
  CHECK(replay::audit_run(run.path()).clean());
}

TEST_CASE("ports of another computer are not opened here, and a host that is gone fails its rows by name",
          "[hosts]") {
  if (no_hosts()) return;
  Experiment e = FarInstruments::part(82);
  e.hosts.address["attic"] = "nowhere";
  e.hosts.of_node["lamp"] = "attic";
  e.devices.lamp = "serial:/dev/firn-no-such-line?baud=19200";
  CHECK(closed_ports(e).empty());
  FarRows rows(e, {});
  for (const PlannedRow& planned : planned_rows(e)) {
    if (planned.node != "lamp" || !rows.has(planned)) continue;
    const BringupResult r = rows.row(planned);
    CHECK(r.state == "failed");
    CHECK_THAT(r.measured, Contains("host attic: "));
  }
  CHECK_THAT(identities_refused(e, {"", {{"lamp", "x"}}, {}}),
             Contains("lamp at serial:") && Contains("host attic"));
}
