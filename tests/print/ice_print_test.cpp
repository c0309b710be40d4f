#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/grid/random.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "replay/ice_error.h"
#include "report/run/report_data.h"
#include "report/run/report_page.h"
#include "studies/tune/ice_disturbance.h"
#include "tests/print/ice_runs.h"

using namespace firn;
using namespace firn::test;

TEST_CASE("A small ice print finishes in process, replays bit for bit, passes the audit and has a report") {
  const Scratch scratch("ice-print");
  const SmallIce s = small_ice_part({});
  const runs::RunFolder run = runs::RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
  const LabRunReport report = run_in_lab(full_product(), run, {});
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK(report.result.layers == 15);
  check_replay(run.path());
  const replay::AuditVerdict audit = check_audit(run.path());
  CHECK(audit.finished);
  CHECK(audit.fired == audit.commanded);

  const report::RunData data = run_data(full_product(), run.path());
  REQUIRE(data.ice);
  CHECK(data.ice->intervals.size() == 3);
  REQUIRE(data.ice->field);
  REQUIRE(data.ice->curve);
  CHECK(data.layers.back().truth);
  const std::optional<OutlineStats>& outline = data.layers.back().true_outline;
  REQUIRE(outline);  // of the block with its scaffold, which is 3.6 mm high
  CHECK_FALSE(data.layers.back().measured_outline);
  CHECK(outline->overspill > 0.0);
  CHECK(outline->overspill < 0.3);
  CHECK(outline->first_ring_mm > 0.0);
  CHECK(outline->first_ring_mm < 3.6);
  CHECK(std::abs(outline->size_error_x_mm) < 1.5);
  CHECK(std::abs(outline->size_error_y_mm) < 1.5);
  CHECK_FALSE(outline->cut);
  bool shown_where_laid = true;
  for (std::size_t c = 0; c < data.height.size(); ++c)
    shown_where_laid &= data.mask.cells[c] || !std::isfinite(data.height.cells[c]);
  CHECK(shown_where_laid);
  const std::string page = report::report_page({{data, "identical"}}, {});
  const std::vector<double> d = ice_disturbance_of(run.path());  // of a plant without drift
  REQUIRE(d.size() == 3);
  for (const double each : d) CHECK(std::abs(each) < 0.2);
  for (const char* section :
       {"Part as built", "Error per interval", "RMS deviation against height", "Along one path"})
    CHECK(page.find(section) != std::string::npos);
}

TEST_CASE(
    "With the bare table measured the first interval is nearer to its height on an uneven table, and report "
    "and tune take the run") {
  double first_mm[2];
  for (const bool on : {false, true}) {
    const Scratch scratch("ice-table");
    const SmallIce s = small_ice_part(
        {std::string("ice.map_table=") + (on ? "on" : "off"), "plant.ice.table_roughness_mm=0.2",
         "laser_point.bias_limit_mm=0.8"});  // four standard deviations of this table
    const runs::RunFolder run = runs::RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
    const LabRunReport report = run_in_lab(full_product(), run, {});
    INFO(report.result.reason);
    REQUIRE(report.result.status == 0);
    const report::RunData data = run_data(full_product(), run.path());
    REQUIRE(data.ice);
    CHECK(data.ice->intervals.size() == 3);
    REQUIRE(data.layers.size() == 3);
    CHECK(data.layers.front().layer == 5);
    first_mm[on] = data.layers.front().rms_mm;
    CHECK(ice_disturbance_of(run.path()).size() == 3);
  }
  CHECK(first_mm[1] < 0.8 * first_mm[0]);
}

TEST_CASE(
    "Feedback brings the true surface nearer to the nominal height than the open loop, whichever way the "
    "valves drift") {
  for (const char* drift : {"-0.2", "0.2"}) {
    const std::vector<std::string> off = {std::string("plant.ice.drift_water=") + drift,
                                          std::string("plant.ice.drift_sme=") + drift};
    double rms_mm[2];
    for (const bool feedback : {false, true}) {
      std::vector<std::string> overrides = off;
      overrides.push_back(feedback ? "control.scheme=smf" : "control.scheme=open_loop");
      const SmallIce s = small_ice_part(overrides);
      const MemoryPrintReport r = print_in_memory(full_product(), s.experiment, s.inputs);
      INFO(r.result.reason);
      REQUIRE(r.result.status == 0);
      rms_mm[feedback] = r.error.rms_mm;
    }
    CAPTURE(drift);
    CHECK(rms_mm[1] < rms_mm[0]);
  }
}

TEST_CASE(
    "An ice print that dies at any step and resumes is finished, replays identical and runs no path twice") {
  const Scratch scratch("ice-resume");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    const SmallIce s =
        small_ice_part(seed % 2 ? std::vector<std::string>{} : std::vector<std::string>{"ice.map_table=on"});
    const runs::RunFolder run = runs::RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
    RandomStream random(seed, Purpose::kKill);
    LabRunReport report;
    for (int n = 0; n == 0 || report.crashed; ++n) {
      LabRunOptions o;
      o.resume = n > 0;
      o.crash_after_steps = n < 2 ? 1 + random.below(60000) : 0;
      report = run_in_lab(full_product(), run, o);
    }
    INFO(report.result.reason);
    REQUIRE(report.result.status == 0);
    check_replay(run.path());
    check_audit(run.path());
  }
}

TEST_CASE("The ice beside a printed block is told from the block, by its lines alone") {
  const SmallIce ice = small_ice_part({"control.scheme=open_loop"});
  const slice::PrintPaths paths = slice::decode_print_paths(blob(ice.inputs, "paths").bytes);
  const replay::NominalPart part =
      replay::nominal_part(paths, replay::kOutlineCell_mm, replay::kOutlineMargin_mm);
  double bead_mm3 = 0.0, part_mm3 = 0.0;
  for (const slice::LayerPaths& l : paths.layers)
    if (const auto use = slice::material_use(l); !use.empty()) bead_mm3 += use[0].volume_mm3;
  for (const double h : part.target.cells) part_mm3 += h * replay::kOutlineCell_mm * replay::kOutlineCell_mm;
  CHECK(part_mm3 == Approx(bead_mm3).epsilon(0.1));  // beads overlap a little and leave voids

  const MemoryPrintReport m = print_in_memory(full_product(), ice.experiment, ice.inputs, {.outline = true});
  CHECK(m.outline.overspill > 0.0);
  CHECK(m.outline.overspill < 0.2);
  CHECK(std::abs(m.outline.size_error_x_mm) < 1.0);
  CHECK(std::abs(m.outline.size_error_y_mm) < 1.0);
  CHECK_FALSE(m.outline.cut);
}

TEST_CASE("A tank that runs empty stops the whole print by name, and the record replays") {
  const Scratch scratch("ice-empty-tank");
  const SmallIce s = small_ice_part({"plant.ice.tank_water_mm3=300", "ice.max_saturated_intervals=2"});
  const runs::RunFolder run = runs::RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
  const LabRunReport report = run_in_lab(full_product(), run, {});
  CHECK(report.result.status == 3);
  CHECK(report.result.layers == 10);
  CHECK(report.result.reason.find("tank empty") != std::string::npos);
  check_replay(run.path());
}
