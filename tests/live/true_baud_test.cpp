// Whole prints whose serial instruments are behind pseudo terminals at their true baud and whose others are
// behind TCP, against the same print over the world's own sockets: the same answers, the same map, the same
// audit, and an identical replay. Of ice no two prints are equal: its maps differ as those of two prints over
// sockets do.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include "cli/audit_command.h"
#include "cli/calibrate_command.h"
#include "config/devices.h"
#include "config/fields.h"
#include "config/include.h"
#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/path_report_t.hpp"
#include "lcmtypes/convert.h"
#include "plant/record/record.h"
#include "print/folder/node_makers.h"
#include "replay/replayer.h"
#include "replay/run_messages.h"
#include "tests/live/live_checks.h"
#include "tests/live/port_bridge.h"
#include "tests/support/long_cases.h"
#include "tests/support/temp_folder.h"

extern char** environ;

using namespace firn;
using namespace firn::test;

namespace {

namespace fs = std::filesystem;

struct Instrument {
  std::string node;
  int baud;  ///< 0: TCP
};
const std::vector<Instrument> kInkjet{{"stage", 0}, {"laser_profiler", 0}, {"jet", 9600}, {"lamp", 19200}},
    kTwoJets{{"stage", 0}, {"laser_profiler", 0}, {"jet", 9600}, {"jet_b", 9600}, {"lamp", 19200}},
    kIce{{"robot", 0}, {"valve_a", 115200}, {"valve_b", 115200}, {"laser_point", 115200}, {"heater", 9600}};

/// A lab as hardware: the world's process on its own, each instrument behind a line.
class Bench {
 public:
  Bench(const Experiment& e, const std::vector<Instrument>& instruments) {
    std::ofstream(folder_.path() / "experiment.toml") << dump(e);
    const std::string program = FIRN_BINARY_DIR "/bin/world", run = folder_.path().string(),
                      epoch = std::to_string(monotonic_ns());
    const char* argv[] = {program.c_str(), "--run", run.c_str(), "--epoch-ns", epoch.c_str(), nullptr};
    REQUIRE(::posix_spawn(&pid_, program.c_str(), nullptr, nullptr, const_cast<char**>(argv), environ) == 0);
    for (const Instrument& i : instruments) {
      const fs::path socket = folder_.path() / "io" / i.node;
      for (int n = 0; n < 2000 && !fs::exists(socket); ++n) ::usleep(5000);
      lines_[i.node] = std::make_unique<PortBridge>(
          i.baud ? PortBridge::Kind::kSerial : PortBridge::Kind::kTcp, socket, i.baud);
    }
  }
  ~Bench() { stop(); }
  void connect(Experiment& e, const std::vector<Instrument>& instruments) const {
    for (const Instrument& i : instruments)
      for (const DevicePort& port : kDevicePorts)
        if (port.node == i.node)
          e.devices.*port.member = lines_.at(i.node)->address(i.baud ? i.baud : 115200);
  }
  void stop() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  fs::path record() const { return folder_.path() / "world.rec"; }

 private:
  TempFolder folder_;
  pid_t pid_ = -1;
  std::map<std::string, std::unique_ptr<PortBridge>> lines_;
};

/// Orders and deeds of a print.
struct Story {
  std::map<std::pair<int, int>, HeightMap> maps;      ///< by layer and attempt
  std::map<std::string, std::map<int, int>> answers;  ///< node -> outcome -> times
  std::vector<std::int64_t> deposited;                ///< of each pass or path, as counted
};

Story story_of(const LiveRun& run) {
  Story s;
  replay::RunMessages messages(run.path());
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    s.maps[{m.layer, m.attempt}] = height_of(m);
  });
  for (const NodeInfo& n : nodes())
    if (n.driver)
      messages.each<answer_t>(channels::answer(n.id).name, [&](const answer_t& a) {
        if (Outcome(a.outcome) != Outcome::kRefused)  // of a lease still to come
          ++s.answers[a.node][a.outcome];
      });
  messages.each<deposition_report_t>(channels::kDepositionReport.name, [&](const deposition_report_t& r) {
    s.deposited.push_back(r.triggered_stage);
  });
  messages.each<path_report_t>(channels::kPathReport.name,
                               [&](const path_report_t& r) { s.deposited.push_back(r.pulses_counted); });
  return s;
}

/// Largest and RMS difference over all maps [mm].
std::pair<double, double> difference(const Story& a, const Story& b) {
  double largest = 0.0, squares = 0.0, n = 0.0;
  for (const auto& [where, map] : a.maps) {
    const HeightMap& other = b.maps.at(where);
    REQUIRE(other.spec == map.spec);
    for (std::size_t c = 0; c < map.size(); ++c) {
      if (!std::isfinite(map.cells[c]) || !std::isfinite(other.cells[c])) continue;
      const double d = std::abs(map.cells[c] - other.cells[c]);
      largest = std::max(largest, d);
      squares += d * d;
      n += 1.0;
    }
  }
  REQUIRE(n > 0.0);
  return {largest, std::sqrt(squares / n)};
}

bool replays(const LiveRun& run) {
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(run.path())) makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions options;
  options.makers = makers;
  return replay::replay_run(run.path(), options).identical();
}

Experiment experiment_of(const std::string& kind) {
  Experiment e = kind == "ice"            ? tiny_ice(51)
                 : kind == "registration" ? load_experiment(FIRN_SOURCE_DIR "/experiments/registration.toml")
                                          : tiny_part(51);
  e.run.time_scale = 1.0;
  if (kind == "ice") return e;
  if (kind == "registration") {
    e.laser_profiler.read = drivers::ProfileRead::kMemory;
    return e;
  }
  e.process.scan_speed_mm_s = 15.0;
  e.part.shape.height_mm = 0.012;
  e.laser_profiler.read = drivers::ProfileRead::kMemory;
  e.plant.model = kind == "lu2015" ? "lu2015" : "droplets";
  return e;
}

}  // namespace

TEST_CASE("a print over lines at true baud is the print over sockets: answers, map, audit, replay") {
  if (skipped()) return;
  std::vector<std::string> kinds =
      long_cases(std::vector<std::string>{"lu2015", "droplets", "ice", "registration"}, 1);
  if (kinds.empty()) kinds = {"lu2015"};  // in the other tenths
  for (const std::string& kind : kinds) {
    CAPTURE(kind);
    const bool ice = kind == "ice";
    const bool two_jets = kind == "registration";
    const std::vector<Instrument>& instruments = ice ? kIce : two_jets ? kTwoJets : kInkjet;
    const Experiment e = experiment_of(kind);
    LiveRun sockets(e);
    sockets.start(false);
    std::optional<LiveRun> again;  // when water freezes depends on when it comes: no two prints are equal
    if (ice) {
      again.emplace(e).start(false);
      REQUIRE(again->wait_started());
    }
    CHECK(status_of(sockets) == 0);
    if (again) CHECK(again->wait() == 0);

    TempFolder scratch;
    Experiment placed = e;
    if (ice) tiny_ice_inputs(placed, scratch.path());
    Bench bench(placed, instruments);
    Experiment real = e;
    bench.connect(real, instruments);
    LiveRun lines(real);
    lines.start(false);
    CHECK(status_of(lines) == 0);
    bench.stop();

    const Story a = story_of(sockets), b = story_of(lines);
    REQUIRE(a.maps.size() == b.maps.size());
    REQUIRE(a.maps.size() >= 2);
    const auto [largest_mm, rms_mm] = difference(a, b);
    WARN(kind << ": maps differ by at most " << largest_mm << " mm, RMS " << rms_mm << " mm");
    if (ice) {
      const double by_chance_mm = difference(a, story_of(*again)).second;
      WARN("two prints over sockets: RMS " << by_chance_mm << " mm");
      CHECK(rms_mm < 0.05);
      CHECK(rms_mm < 3.0 * by_chance_mm);
      REQUIRE(a.deposited.size() == b.deposited.size());
    } else {
      // A nozzle warms and wets in time: droplets differ by parts of themselves, at single cells.
      CHECK(largest_mm <= (two_jets ? 0.004 : 0.0));
      CHECK(rms_mm <= 1e-4);
      CHECK(a.deposited == b.deposited);
    }
    CHECK(a.answers == b.answers);
    CHECK(replays(sockets));
    CHECK(replays(lines));
    const replay::AuditVerdict of_sockets = audit_verdict(sockets.path()),
                               of_lines = audit_verdict(lines.path());
    CHECK(of_sockets.clean());
    CHECK(of_lines.clean());
    if (two_jets) {
      const Calibration of_a = calibrate(sockets.path()), of_b = calibrate(lines.path());
      CHECK(of_b.offset_x_mm() == Approx(of_a.offset_x_mm()).margin(0.01 * of_a.off.x.ci95_half_width_mm));
      CHECK(of_b.offset_y_mm() == Approx(of_a.offset_y_mm()).margin(0.01 * of_a.off.y.ci95_half_width_mm));
    }
    if (ice) continue;
    CHECK(of_lines.commanded == of_sockets.commanded);
    const auto fired = [](const fs::path& record) {
      std::int64_t n = 0;
      for (const auto& shot : plant::read_history(record).shots)
        n += shot.outcome == plant::ShotOutcome::kFired;
      return n;
    };
    CHECK(fired(bench.record()) == fired(sockets.folder().world_record_path()));
  }
}
