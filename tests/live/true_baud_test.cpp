// Whole prints whose serial instruments are behind pseudo terminals at their true baud and whose others are
// behind TCP, against the same print over the world's own sockets: the same answers, the same map, the same
// audit, and an identical replay. An ice part depends on when its paths begin (the end effector's swing
// after a move, warm coils, thermostats, the jet's wander): by a nature without those its maps are equal too,
// by all of nature they differ as those of prints over sockets whose robot answers at other times.
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
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_fault.h"
#include "replay/audit_run.h"
#include "replay/replayer.h"
#include "runs/read/run_reader.h"
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

/// A lab as hardware: the world's process on its own, each instrument behind a line that carries its bytes at
/// its baud (the world's own lines carry them at once then), or behind the world's sockets.
class Bench {
 public:
  enum class Way { kLines, kSockets };
  Bench(const std::vector<Instrument>& instruments, Way way) : instruments_(instruments) {
    if (way == Way::kSockets) return;
    for (const Instrument& i : instruments)
      lines_[i.node] = std::make_unique<PortBridge>(
          i.baud ? PortBridge::Kind::kSerial : PortBridge::Kind::kTcp, socket(i), i.baud);
  }
  ~Bench() { stop(); }
  void connect(Experiment& e) const {
    for (const Instrument& i : instruments_)
      for (const DevicePort& port : kDevicePorts)
        if (port.node == i.node)
          e.devices.*port.member = lines_.empty() ? "unix:" + socket(i).string()
                                                  : lines_.at(i.node)->address(i.baud ? i.baud : 115200);
  }
  /// From now on the world's time runs. @param steady nature does not depend on when a path begins
  void start(const Experiment& e, bool steady) {
    std::ofstream(folder_.path() / "experiment.toml") << dump(e);
    std::vector<std::string> words{FIRN_BINARY_DIR "/bin/world", "--run", folder_.path().string(),
                                   "--epoch-ns", std::to_string(monotonic_ns())};
    if (!lines_.empty()) words.insert(words.end(), {"--line-speed", "1e6"});
    if (steady) words.insert(words.end(), {"--nature", "steady"});
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    REQUIRE(::posix_spawn(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) == 0);
  }
  void stop() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  fs::path record() const { return folder_.path() / "world.rec"; }

 private:
  fs::path socket(const Instrument& i) const { return folder_.path() / "io" / i.node; }

  TempFolder folder_;
  const std::vector<Instrument>& instruments_;
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
  runs::RunReader messages(run.path());
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
  for (const NamedMaker& m : taking_part(full_product(), run.path()))
    makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions options;
  options.makers = makers;
  return replay::replay_run(run.path(), options).identical();
}

// A path begins with the rest of the end effector's swing (12 Hz) after the move before: a robot's
// answers that are late by this turn its phase as those over a line do.
constexpr const char* kLaterRobot = "0 robot delay 1000000 10000";
constexpr const char *kIceKind = "ice", *kSteadyIceKind = "ice, steady", *kTwoInksKind = "registration";

Experiment experiment_of(const std::string& kind) {
  const bool ice = kind == kIceKind || kind == kSteadyIceKind;
  Experiment e = ice                    ? tiny_ice(51)
                 : kind == kTwoInksKind ? load_experiment(FIRN_SOURCE_DIR "/experiments/registration.toml")
                                        : tiny_part(51);
  e.run.time_scale = 1.0;
  if (ice) return e;
  e.laser_profiler.read = drivers::ProfileRead::kMemory;
  if (kind == kTwoInksKind) return e;
  e.process.scan_speed_mm_s = 15.0;
  e.part.shape.height_mm = 0.012;
  e.plant.model = kind == "lu2015" ? "lu2015" : "droplets";
  e.plant.drift = 0.0;  // of the nozzle, with time: on a loaded computer one of the prints takes longer
  return e;
}

std::int64_t fired_in_world(const fs::path& record) {
  const plant::WorldHistory world = plant::read_history(record);
  std::int64_t n = 0;
  for (const auto& shot : world.shots) n += shot.outcome == plant::ShotOutcome::kFired;
  for (const auto& list : world.firings) n += list.fired;
  return n;
}

void compare_lines_with_sockets(const std::string& kind) {
  CAPTURE(kind);
  const bool by_chance = kind == kIceKind, steady = kind == kSteadyIceKind, two_jets = kind == kTwoInksKind;
  const bool ice = by_chance || steady;
  const std::vector<Instrument>& instruments = ice ? kIce : two_jets ? kTwoJets : kInkjet;
  const Experiment e = experiment_of(kind);
  TempFolder scratch;
  Experiment placed = e;
  if (ice) tiny_ice_inputs(placed, scratch.path());

  std::optional<Bench> beside;  // a world that is not the print's own
  Experiment over_sockets = e;
  if (steady) beside.emplace(instruments, Bench::Way::kSockets).connect(over_sockets);
  LiveRun sockets(over_sockets);
  if (beside) beside->start(placed, true);
  sockets.start(false);
  std::optional<LiveRun> again;
  if (by_chance) {
    again.emplace(e).faults = parse_lab_faults({kLaterRobot}, e);
    again->start(false);
    REQUIRE(again->wait_started());
  }
  const auto end_of_sockets = [&] {
    CHECK(status_of(sockets) == 0);
    if (again) CHECK(again->wait() == 0);
    if (beside) beside->stop();
  };
  if (!steady) end_of_sockets();  // a steady nature lets both print side by side

  Bench bench(instruments, Bench::Way::kLines);
  Experiment real = e;
  bench.connect(real);
  LiveRun lines(real);
  bench.start(placed, steady);
  lines.start(false);
  if (steady) end_of_sockets();
  CHECK(status_of(lines) == 0);
  bench.stop();

  const Story a = story_of(sockets), b = story_of(lines);
  REQUIRE(a.maps.size() == b.maps.size());
  REQUIRE(a.maps.size() >= 2);
  const auto [largest_mm, rms_mm] = difference(a, b);
  WARN(kind << ": maps differ by at most " << largest_mm << " mm, RMS " << rms_mm << " mm");
  if (by_chance) {
    const double by_chance_mm = difference(a, story_of(*again)).second;
    WARN("over sockets, of a robot that answers later: RMS " << by_chance_mm << " mm");
    CHECK(rms_mm < 0.05);
    CHECK(rms_mm < 2.0 * by_chance_mm);
    REQUIRE(a.deposited.size() == b.deposited.size());
  } else {
    // A nozzle warms and wets in time: droplets differ by parts of themselves, at single cells. A steady
    // arm's rest after a move differs by less than a step of the laser's display.
    CHECK(largest_mm <= (two_jets ? 0.004 : steady ? 1e-4 : 0.0));
    CHECK(rms_mm <= 1e-4);
    CHECK(a.deposited == b.deposited);
  }
  CHECK(a.answers == b.answers);
  CHECK(replays(sockets));
  CHECK(replays(lines));
  const replay::AuditVerdict of_sockets = replay::audit_run(sockets.path()),
                             of_lines = replay::audit_run(lines.path());
  CHECK(of_sockets.clean());
  CHECK(of_lines.clean());
  if (two_jets) {
    const Calibration of_a = calibrate(sockets.path()), of_b = calibrate(lines.path());
    CHECK(of_b.offset_x_mm() == Approx(of_a.offset_x_mm()).margin(0.01 * of_a.off.x.ci95_half_width_mm));
    CHECK(of_b.offset_y_mm() == Approx(of_a.offset_y_mm()).margin(0.01 * of_a.off.y.ci95_half_width_mm));
  }
  if (by_chance) return;
  CHECK(of_lines.commanded == of_sockets.commanded);
  CHECK(fired_in_world(bench.record()) ==
        fired_in_world(beside ? beside->record() : sockets.folder().world_record_path()));
}

}  // namespace

TEST_CASE("a print over lines at true baud is the print over sockets: answers, map, audit, replay") {
  if (skipped()) return;
  const std::vector<std::string> kinds{"lu2015", "droplets", kIceKind, kTwoInksKind};
  for (const std::string& kind : long_cases(kinds, 1)) compare_lines_with_sockets(kind);
}

TEST_CASE(
    "a print over lines at true baud has the map of that over sockets, be it of droplets or of steady ice") {
  if (skipped()) return;
  const std::vector<std::string> kinds{"droplets", kSteadyIceKind};
  for (const std::string& kind : long_cases(kinds, 1)) compare_lines_with_sockets(kind);
}
