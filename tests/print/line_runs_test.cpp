// Runs of the aerosol lab with a folder: replay, audit, report, death and resume, faults.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "cli/replay_command.h"
#include "config/include.h"
#include "core/grid/random.h"
#include "files/usage_error.h"
#include "firn/followed_path_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/path_report_t.hpp"
#include "page/run_set.h"
#include "plant/record/record.h"
#include "print/folder/observed_run.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "report/run/report_data.h"
#include "report/run/report_page.h"
#include "runs/read/run_reader.h"
#include "studies/compare/recorded_study.h"
#include "studies/tune/lab_print.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using firn::test::Scratch;

namespace {

/// Two short lines in few layers.
struct ShortLines {
  Scratch scratch{"lines"};
  Experiment experiment;
  runs::RunFolder run;

  explicit ShortLines(std::vector<std::string> more = {})
      : experiment(load(std::move(more))),
        run(runs::RunFolder::create(scratch / "runs", experiment,
                                    make_inputs(full_product(), experiment, kLineFolder), {"test"})) {}

  static inline const std::filesystem::path kLineFolder =
      std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

  static Experiment load(std::vector<std::string> more) {
    std::vector<std::string> set{"aerosol.job=aerosol-lines.json", "aerosol.layers=3", "grid.nx=250",
                                 "grid.ny=80"};
    set.insert(set.end(), more.begin(), more.end());
    return load_experiment(kLineFolder / "aerosol-meander.toml", set);
  }

  LabRunReport go(const std::vector<std::string>& faults = {}, bool resume = false,
                  std::uint64_t crash_after = 0) {
    LabRunOptions o;
    o.resume = resume;
    o.crash_after_steps = crash_after;
    o.faults = parse_lab_faults(faults, experiment);
    return run_in_lab(full_product(), run, o);
  }
  void check_replay() const {
    ReplayCommandOptions r;
    r.run = run.path().string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    CHECK(verdict.identical());
  }
  replay::AuditVerdict check_audit() const {
    const replay::AuditVerdict audit = replay::audit_run(run.path());
    INFO(replay::to_text(audit));
    CHECK(audit.clean());
    return audit;
  }
};

/// The pulses of that layer in a print that nothing disturbs.
plant::FiringRecord firing_of_layer(std::size_t layer, const std::vector<std::string>& more) {
  static std::map<std::vector<std::string>, std::vector<plant::FiringRecord>>& known =
      *new auto(std::map<std::vector<std::string>, std::vector<plant::FiringRecord>>{});
  if (!known.contains(more)) {
    ShortLines lines(more);
    REQUIRE(lines.go().result.status == 0);
    known[more] = plant::read_history(lines.run.world_record_path()).firings;
  }
  return known.at(more).at(layer - 1);
}

/// A moment of node time, in s, at which the shutter is open in that layer.
std::string open_in_layer(std::size_t layer, const std::vector<std::string>& more = {}) {
  return std::to_string(double(firing_of_layer(layer, more).first_us) * 1e-6 + 0.5);
}

/// The same of the closed shutter, behind that layer.
std::string closed_after_layer(std::size_t layer, const std::vector<std::string>& more) {
  return std::to_string(double(firing_of_layer(layer, more).end_us) * 1e-6 + 0.5);
}

/// Stopped by name, no switch is open at the end, and the record holds.
void check_line_stop(const ShortLines& lines, const LabRunReport& stopped, const std::string& name) {
  INFO(stopped.result.reason);
  CHECK(stopped.result.status == 3);
  CHECK_THAT(stopped.result.reason, Catch::Contains(name));
  for (const plant::FiringRecord& f : plant::read_history(lines.run.world_record_path()).firings)
    CHECK(f.end_us > 0);
  lines.check_replay();
  lines.check_audit();
}

/// The instrument is mended, and the print goes on to its end.
void check_goes_on(ShortLines& lines, int layers) {
  const LabRunReport report = lines.go({"0 stage trip 0"}, true);
  INFO(report.result.reason);
  CHECK_FALSE(runs::can_go_on(report.result));
  CHECK(report.result.layers == layers);
  lines.check_replay();
  CHECK(lines.check_audit().finished);
}

}  // namespace

TEST_CASE("A print of lines replays bit for bit, passes the audit and has a report of its lines", "[line]") {
  ShortLines lines;
  const LabRunReport report = lines.go();
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK(report.result.layers == 3);
  lines.check_replay();
  const replay::AuditVerdict audit = lines.check_audit();
  CHECK(audit.finished);
  CHECK(audit.commanded == 3 * 4);
  CHECK(audit.fired == audit.commanded);
  const report::RunData data = run_data(full_product(), lines.run.path());
  CHECK(data.layers.size() == 4);
  CHECK(data.layers.back().truth);
  const std::string page = report::report_page({{data, "identical"}}, {});
  for (const char* section :
       {"Lines", "Cross-section", "close delay", "Switches", "Followed path", "Contour error along"})
    CHECK(page.find(section) != std::string::npos);
  CHECK(page.find("<td>0.0</td>") == std::string::npos);  // delays that no layer was planned with
}

TEST_CASE("A layer of lines counts its own seconds and no others'", "[line]") {
  ShortLines lines;
  REQUIRE(lines.go().result.status == 0);
  std::vector<double> scans_s;
  runs::RunReader(lines.run.path())
      .each<layer_metrics_t>(channels::kLayerMetrics.name,
                             [&](const layer_metrics_t& m) { scans_s.push_back(m.scan_s); });
  REQUIRE(scans_s.size() == 4);
  for (const double s : scans_s) CHECK(s == Approx(scans_s[1]).epsilon(0.3));
}

TEST_CASE(
    "A print of lines that dies at any step and resumes is finished, identical, and no way is run twice",
    "[line][seeded]") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    ShortLines lines;
    RandomStream random(seed, Purpose::kKill);
    LabRunReport report = lines.go({}, false, 1 + random.below(12'000));
    for (int n = 1; report.crashed || report.result.status == 3; ++n) {
      REQUIRE(n < 6);
      report = lines.go({}, true, n < 2 ? 1 + random.below(12'000) : 0);
    }
    INFO(report.result.reason);
    CHECK(report.result.status == 0);
    CHECK(report.result.layers == 3);
    lines.check_replay();
    lines.check_audit();
  }
}

TEST_CASE(
    "A print by the camera alone dies, resumes, replays bit for bit, and its pictures are the audit's "
    "evidence",
    "[line]") {
  ShortLines lines({"devices.laser_profiler.port=none", "camera.use=on", "aerosol.width_by=speed",
                    "aerosol.layers=2", "aerosol.station_mm=1.6"});
  LabRunReport report = lines.go({}, false, 3'000);
  CHECK(report.crashed);
  report = lines.go({}, true);
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK(report.result.layers == 2);
  lines.check_replay();
  CHECK(lines.check_audit().finished);
  const report::RunData data = run_data(full_product(), lines.run.path());
  CHECK(data.layers.size() == 3);
  const std::string page = report::report_page({{data, "identical"}}, {});
  for (const char* words : {"not judged: heights were not measured", "a camera and no profiler", "Switches"})
    CHECK(page.find(words) != std::string::npos);
  for (const std::string words : {"Cross-section", "RMS error about", ">nan"}) {
    CAPTURE(words);
    CHECK(page.find(words) == std::string::npos);
  }
  CHECK_THROWS_WITH(recorded_study(study_of_runs({lines.run.path().string()}), ""),
                    Catch::Contains(lines.run.path().string() + ": heights were not measured"));
}

TEST_CASE("A shutter that stays closed stops a print by the camera alone, by name", "[line][I12]") {
  ShortLines lines({"devices.laser_profiler.port=none", "camera.use=on", "aerosol.width_by=speed",
                    "aerosol.layers=2", "aerosol.station_mm=1.6"});
  const LabRunReport stopped = lines.go({"1 stage trip 7"});
  check_line_stop(lines, stopped, "shutter stays closed");
}

TEST_CASE(
    "A shutter that sticks closed after layer 1 stops a print by the camera alone, and it goes on mended",
    "[line][I12]") {
  const std::vector<std::string> alone{"devices.laser_profiler.port=none", "camera.use=on",
                                       "aerosol.width_by=speed", "aerosol.layers=2",
                                       "aerosol.station_mm=1.6"};
  const std::string moment = closed_after_layer(1, alone);
  ShortLines stuck(alone);
  const LabRunReport stopped = stuck.go({moment + " stage trip 7"});
  check_line_stop(stuck, stopped, "the lines of layer 2 hold");
  CHECK_THAT(stopped.result.reason, Catch::Contains("shutter stays closed"));
  check_goes_on(stuck, 2);
}

TEST_CASE("A shutter that stays open stops a print by the camera alone, by name, until somebody mends it",
          "[line][I12]") {
  const std::vector<std::string> alone{"devices.laser_profiler.port=none", "camera.use=on",
                                       "aerosol.width_by=speed", "aerosol.station_mm=1.6",
                                       "aerosol.layers=2"};
  const std::string moment = open_in_layer(1, alone);
  ShortLines stuck(alone);
  LabRunReport report = stuck.go({moment + " stage trip 7"});
  check_line_stop(stuck, report, "shutter stays open");
  // The shutter is left open: its output, which toggles, must be set right as well.
  for (int n = 0; n < 3 && report.result.status == 3; ++n) report = stuck.go({"0 stage trip 0"}, true);
  INFO(report.result.reason);
  CHECK(report.result.status == 0);
  CHECK(report.result.layers == 2);
}

TEST_CASE("A run of lines is listed with its lab, and what learns droplets refuses it by name", "[line]") {
  ShortLines lines({"aerosol.layers=1"});
  REQUIRE(lines.go().result.status == 0);
  CHECK_THAT(page::RunSet({lines.scratch / "runs"}, {}).list()(), Catch::Contains("\"lab\":\"aerosol\""));
  CHECK_THROWS_WITH(tune::RecordedRun::read(lines.run.path()), Catch::Contains("lab.kind = \"aerosol\""));
  CHECK_THROWS_WITH(ObservedRun::read(lines.run.path()), Catch::Contains("lab.kind = \"aerosol\""));
}

TEST_CASE("A shutter that stays closed stops the print at the next map, by name", "[line][I12]") {
  ShortLines lines;
  const LabRunReport stopped = lines.go({"1 stage trip 7"});
  check_line_stop(lines, stopped, "shutter stays closed");
}

TEST_CASE("A shutter that stays open stops the print at the next map, by name", "[line][I12]") {
  const std::string moment = open_in_layer(2);
  ShortLines lines;
  const LabRunReport stopped = lines.go({moment + " stage trip 7"});
  check_line_stop(lines, stopped, "shutter stays open");
}

TEST_CASE("Ink beside the lines stops the print by the two keys of its limit", "[line][I12]") {
  const std::string key = GENERATE("process.most_beside_share=1e6", "process.beside_mm=100");
  const std::string moment = open_in_layer(2);
  ShortLines lines({key});
  const LabRunReport report = lines.go({moment + " stage trip 7"});
  CHECK(report.result.reason.find("the shutter stays open") == std::string::npos);
}

TEST_CASE(
    "An axis that stands while the shutter is open: the shutter closes at once, the print stops by name",
    "[line][I5]") {
  const std::string moment = open_in_layer(2);
  ShortLines lines;
  const LabRunReport stopped = lines.go({moment + " stage trip 3"});
  check_line_stop(lines, stopped, "1 pulses counted, 4 commanded");
  const plant::FiringRecord cut = plant::read_history(lines.run.world_record_path()).firings.back();
  CHECK(cut.fired == 1);
  CHECK(double(cut.end_us) * 1e-6 - std::stod(moment) < 0.3);  // two polls of the axes
  check_goes_on(lines, 3);
}

TEST_CASE("Switches that are not put out: the count stops the print, and the layer is in doubt", "[line]") {
  const std::string scheme = GENERATE("smf", "open_loop");
  const std::string moment = open_in_layer(2);
  ShortLines lines({"control.scheme=" + scheme});
  const LabRunReport stopped = lines.go({moment + " stage trip 5"});
  check_line_stop(lines, stopped, "1 pulses counted, 4 commanded");
  if (scheme == "smf") return check_goes_on(lines, 3);
  const LabRunReport waits = lines.go({"0 stage trip 0"}, true);
  CHECK_THAT(waits.result.reason, Catch::Contains("--accept-doubt"));
}

TEST_CASE("Each layer's followed path is recorded with its errors, which the stage's servo explains",
          "[line][followed]") {
  ShortLines lines({"aerosol.layers=2"});
  REQUIRE(lines.go().result.status == 0);
  const runs::RunReader messages(lines.run.path());
  std::vector<path_report_t> reports;
  messages.each<path_report_t>(channels::kPathReport.name,
                               [&](const path_report_t& m) { reports.push_back(m); });
  std::vector<followed_path_t> paths;
  messages.each<followed_path_t>(channels::kFollowedPath.name,
                                 [&](const followed_path_t& m) { paths.push_back(m); });
  REQUIRE(reports.size() == 2);
  REQUIRE(paths.size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const path_report_t& r = reports[k];
    CHECK(r.samples == paths[k].n);
    CHECK(double(r.samples) * paths[k].period_s >= r.planned_s);
    CHECK(r.lag_max_s > 0.0);
    CHECK(r.lag_max_s < 0.002);
    CHECK(r.contour_max_mm < 0.01);
    CHECK(r.contour_rms_mm <= r.contour_max_mm);
    CHECK(r.switch_max_mm < 0.01);
    CHECK(r.offset_rms_mm < 0.002);
  }
}

TEST_CASE(
    "A stage that drags off its path stops the print by name, the layer is in doubt, and it goes on mended",
    "[line][followed][I17]") {
  const std::string moment = open_in_layer(2);
  ShortLines lines({"plant.aerosol.servo_feed_forward=0.5"});
  const LabRunReport stopped = lines.go({moment + " stage trip 9"});
  check_line_stop(lines, stopped, "layer 2: the stage was");
  CHECK_THAT(stopped.result.reason, Catch::Contains("process.most_path_error_mm"));
  check_goes_on(lines, 3);
}

TEST_CASE("The same drag within a wider process.most_path_error_mm is printed through",
          "[line][followed][I17]") {
  const std::string moment = open_in_layer(2);
  ShortLines lines({"plant.aerosol.servo_feed_forward=0.5", "process.most_path_error_mm=3"});
  CHECK(lines.go({moment + " stage trip 9"}).result.status == 0);
}

TEST_CASE("An encoder that sticks stops the print by name, with the shutter closed",
          "[line][followed][I17]") {
  const std::string moment = open_in_layer(2);
  ShortLines lines;
  const LabRunReport stopped = lines.go({moment + " stage trip 10"});
  check_line_stop(lines, stopped, "stage: ");
  check_goes_on(lines, 3);
}
