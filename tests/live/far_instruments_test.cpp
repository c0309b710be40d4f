// Real instruments at another computer: bring-up, identity, a print on them, and a calibration.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "config/devices.h"
#include "config/labs.h"
#include "files/json.h"
#include "files/text_file.h"
#include "print/bringup/far_instruments.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "studies/calibrate/lab_calibrations.h"
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

namespace {

/// The ice lab with all its instruments at sockets of a world that runs by the clock, which the host sees.
struct FarIce {
  FarIce() : world(laid_out(load_lab_experiment(kIce, keys()))), e(load_lab_experiment(kIce, keys())) {
    for (const DevicePort& port : kDevicePorts)
      if (takes_part(e, port.node)) e.devices.*port.member = to_text(world.address(std::string(port.node)));
    e.ice.machine = FIRN_SOURCE_DIR "/labs/" + e.ice.machine;
    e.hosts.address["attic"] = "attic:" FIRN_BINARY_DIR "/bin/firn";
    for (const std::string& node : simulated_ports(laid_out(load_lab_experiment(kIce, keys()))))
      e.hosts.of_node[node] = "attic";
  }
  static std::vector<std::string> keys() { return {"heater.low_degC=-40"}; }  // warm enough at once
  static Experiment laid_out(const Experiment& lab) {
    using namespace lab_calibrations;
    return with_jig(with_field(lab, -60.0, -60.0, 10.0, 10.0));
  }
  /// In a file of this folder.
  Said calibrated(const TempFolder& folder, const std::vector<std::string>& more = {}) const {
    const std::string file = (folder.path() / "lab.toml").string();
    std::ofstream(file) << dump(e);
    std::vector<std::string> words{"calibrate", "laser-latency", file, "--repeats", "4"};
    words.insert(words.end(), more.begin(), more.end());
    return firn_says(words);
  }
  SimulatedInstruments world;
  Experiment e;
};

}  // namespace

TEST_CASE("a calibration is carried out at the computer of its instruments, and its result comes here",
          "[hosts]") {
  if (no_hosts()) return;
  const FarHosts hosts({"attic"});
  const FarIce lab;
  const TempFolder folder;
  const std::string plot = (folder.path() / "plot.svg").string();
  const Said said = lab.calibrated(folder, {"--json", "--plot", plot});
  INFO(said.out << said.err);
  REQUIRE(said.code == 0);
  const auto answer = nlohmann::json::parse(said.out);
  CHECK(answer["keys"][0]["key"] == "laser_point.latency_s");
  CHECK(answer["lab_s"].get<double>() > 1.0);  // by the clock
  CHECK_THAT(read_file(plot), Contains("<svg"));
  CHECK_THAT(read_file(folder.path() / "lab.proposed.toml"), Contains("firn calibrate laser-latency"));
}

TEST_CASE("a calibration whose instruments are at two computers is refused by name", "[hosts]") {
  if (no_hosts()) return;
  FarIce lab;
  lab.e.hosts.of_node.erase("heater");
  const TempFolder folder;
  const Said said = lab.calibrated(folder);
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains("needs its instruments at one computer") && Contains("heater here") &&
                           Contains("laser_point at host attic"));
  lab.e.hosts.of_node["heater"] = "attic";
  lab.e.hosts.address["attic"] = "nowhere";
  CHECK_THAT(lab.calibrated(folder).err, Contains("host attic (nowhere) cannot be reached"));
}
