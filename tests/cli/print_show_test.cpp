// Tests the lines that a print shows at its end.
#include <catch2/catch.hpp>
#include <cmath>

#include "cli/print_show.h"
#include "config/include.h"
#include "core/grid/outline.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "print/print_judge.h"
#include "runs/folder/verdict.h"
#include "tests/print/ice_runs.h"

using namespace firn;
using Catch::Contains;

namespace {

PrintSummary over(runs::RunResult result) {
  PrintSummary s;
  s.scheme = "open_loop";
  s.result = std::move(result);
  return s;
}

layer_metrics_t measured(double rms_um) {
  layer_metrics_t m{};
  m.map_id = 3;
  m.rms_mm = rms_um * 1e-3;
  return m;
}

// The result of a print that the scheduler ended so, after a last map with this RMS; 0: no map.
runs::RunResult judged(runs::RunResult result, double rms_um, double asked_um = 0.0, Experiment e = {}) {
  PrintJudge judge(full_product(), e, asked_um);
  if (rms_um > 0.0) judge.take(measured(rms_um));
  judge.judge(result);
  return result;
}

Experiment without_target() {
  Experiment e;
  e.control.scheme = "pattern";
  return e;
}

const runs::RunResult kDone{"finished", kOk, 30, "the last layer is printed"},
    kDry{"out of tolerance", kOutOfTolerance, 30, "valve_a gives nothing"},
    kStopped{"stopped safely", kSafetyStop, 12, "robot: link lost"};

std::string last_line(const std::string& text) { return text.substr(text.rfind('\n', text.size() - 2) + 1); }

PrintSummary printed(Experiment e, const Blobs& inputs, const std::filesystem::path& runs,
                     double tolerance_um) {
  PrintOptions o;
  o.bus = "in-process";
  o.runs = runs.string();
  o.tolerance_um = tolerance_um;
  return print_experiment(full_product(), e, inputs, o);
}

}  // namespace

TEST_CASE("The usual tolerance is one nominal layer, in both labs, and none where a print has no target") {
  Experiment e;
  CHECK(usual_tolerance_um(full_product(), e) == Approx(7.6));
  e.control.scheme = "open_loop";
  CHECK(usual_tolerance_um(full_product(), e) == Approx(7.6));
  e.control.open_loop.layers = 3;
  CHECK(usual_tolerance_um(full_product(), e) == 0.0);
  for (const char* scheme : {"pattern", "registration"}) {
    e.control.scheme = scheme;
    CHECK(usual_tolerance_um(full_product(), e) == 0.0);
  }
  Experiment ice;
  ice.lab.kind = "ice";
  ice.control.scheme = "open_loop";
  CHECK(usual_tolerance_um(full_product(), ice) == Approx(240.0));
}

TEST_CASE("The last line of a print gives its verdict, and out of tolerance has an exit code of its own") {
  struct Case {
    runs::RunResult result;
    std::optional<bool> within;
    int code;
    std::string line;
  };
  const Case cases[] = {
      {judged(kDone, 7.0), true, kOk, "within tolerance: RMS 7 um of the last map, at most 7.6 um"},
      {judged(kDone, 80.0), false, kOutOfTolerance,
       "OUT OF TOLERANCE: RMS 80 um of the last map, more than 7.6 um, one layer; the last layer"},
      {judged(kDone, 80.0, 70.0), false, kOutOfTolerance,
       "OUT OF TOLERANCE: RMS 80 um of the last map, more than 70 um; the last layer"},
      {judged(kDone, 7.0, 7.6), true, kOk, "within tolerance"},
      {judged(kDry, 7.0), false, kOutOfTolerance, "OUT OF TOLERANCE: valve_a gives nothing"},
      {judged(kStopped, 7.0, 7.6), std::nullopt, kSafetyStop, "to go on: firn print --resume"},
      {judged(kDone, 0.0, 7.6), std::nullopt, kFailed, "nothing was measured"},
      {judged(kDone, 7.0, 0.0, without_target()), std::nullopt, kOk, "no target"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.line);
    CHECK(within_tolerance(c.result) == c.within);
    CHECK(c.result.status == c.code);
    CHECK_THAT(last_line(print_text(over(c.result))), Contains(c.line));
    const auto j = nlohmann::json::parse(print_json(over(c.result)));
    CHECK(j["status"] == c.code);
    CHECK(j["within_tolerance"].is_null() == !c.within.has_value());
    if (c.within) CHECK(j["within_tolerance"] == *c.within);
  }
}

TEST_CASE("A result reads back from its file as it was written, judged or not, with its facts or without") {
  runs::RunResult full = judged(kDone, 80.0);
  full.part = runs::PrintedPart{"mesh a \"b\".stl", {10.25, 4.0, 0.4}};
  full.overspill_percent = 9.25;
  full.audit = "1 violation: layer 3, pass 2: a cell twice";
  full.outline.emplace();
  full.outline->missing = 0.0042;
  full.outline->size_error_x_mm = -0.0312;
  full.outline->edge_width_mm = 0.2124;
  full.outline->cut = true;
  for (const runs::RunResult& r : {judged(kDone, 80.0), judged(kDone, 0.0), kStopped, full}) {
    const runs::RunResult read = runs::parse_result(runs::result_text(r), "result.json");
    CHECK(read.outcome == r.outcome);
    CHECK(read.status == r.status);
    CHECK(read.layers == r.layers);
    CHECK(read.reason == r.reason);
    CHECK(read.tolerance_um == r.tolerance_um);
    REQUIRE(read.error.has_value() == r.error.has_value());
    if (r.error) CHECK(read.error->rms_um == r.error->rms_um);
    REQUIRE(read.part.has_value() == r.part.has_value());
    if (r.part) CHECK((read.part->name == r.part->name && read.part->size_mm == r.part->size_mm));
    CHECK(read.overspill_percent == r.overspill_percent);
    CHECK(read.audit == r.audit);
    REQUIRE(read.outline.has_value() == r.outline.has_value());
    if (r.outline) CHECK(read.outline->cut == r.outline->cut);
    for (const OutlineMetric& m : kOutlineMetrics)
      if (r.outline)
        CHECK(((*read.outline).*m.value == Approx((*r.outline).*m.value) ||
               (std::isnan((*read.outline).*m.value) && std::isnan((*r.outline).*m.value))));
  }
  const std::string older = R"({"outcome": "finished", "status": 0, "layers": 3, "reason": "done"})";
  CHECK_FALSE(runs::parse_result(older, "result.json").part);
  CHECK(verdict_words(runs::parse_result(older, "result.json"), LabWords{}) == "not judged");
  for (const char* wrong : {R"("part": 3)", R"("part": {"name": "x"})",
                            R"("part": {"name": "x", "size_mm": [1, 2]})", R"("overspill_percent": "9")",
                            R"("audit": 0)", R"("outline": 3)", R"("outline": {"missing_pct": "9"})"})
    CHECK_THROWS_WITH(
        runs::parse_result(older.substr(0, older.size() - 1) + ", " + wrong + "}", "result.json"),
        Contains("result.json: "));
}

TEST_CASE("A print tells its missing volume beside its overspill, and what is known of its edge") {
  runs::RunResult r = judged(kDone, 3.0);
  r.overspill_percent = 9.2468;
  r.outline.emplace();
  r.outline->missing = 0.00521;
  r.outline->edge_width_mm = 0.2124;
  CHECK_THAT(
      result_lines(r, lab_words("inkjet")),
      Contains("overspill of the measured surface: 9.25 % of the part's volume lies beside it, 0.521 % is "
               "missing inside\n"
               "edge of the measured surface: 212 um wide from 10 to 90 % of the height\n"));
  r.outline->size_error_x_mm = 0.441;
  r.outline->size_error_y_mm = -0.0312;
  r.outline->corner_radius_mm = 0.09;
  CHECK_THAT(result_lines(r, lab_words("inkjet")),
             Contains("; size error 441 um along x, -31.2 um along y; corners of radius 90 um\n"));
  r.outline->cut = true;
  CHECK_THAT(result_lines(r, lab_words("inkjet")),
             Contains("; size error at least 441 um along x, -31.2 um"));
  const auto json = nlohmann::json::parse(print_json(over(r)));
  CHECK(json["missing_pct"].get<double>() == Approx(0.521));
  CHECK(json["part_rms_um"].is_null());
}

TEST_CASE("Ice is told in mm and pulses, the ink-jet in um and droplets, both in three significant digits") {
  runs::RunResult r = judged(kDone, 117.4, 240.0);
  r.error->rms_inside_um = 108.9;
  r.error->rms_rim_um = 140.2;
  r.part = runs::PrintedPart{"mesh gear.stl", {30.123, 30.0, 7.2}};
  r.overspill_percent = 9.2468;
  r.audit = "clean";
  CHECK(result_lines(r, lab_words("ice")) ==
        "part: mesh gear.stl, 30.1 x 30 x 7.2 mm\n"
        "measured surface against the nominal height: mean +0 mm, RMS 0.117 mm, std 0 mm\n"
        "RMS inside 0.109 mm, on the rim 0.14 mm\n"
        "overspill of the measured surface: 9.25 % of the part's volume lies beside it\n"
        "audit: clean\n");
  CHECK(verdict_words(r, lab_words("ice")) ==
        "within tolerance: RMS 0.117 mm of the last map, at most 0.24 mm");
  CHECK_THAT(result_lines(r, lab_words("inkjet")), Contains("RMS 117 um") && Contains("against target"));
  PrintSummary s = over(r);
  s.words = lab_words("ice");
  s.droplets = 1234;
  CHECK_THAT(print_text(s), Contains("1234 pulses"));
  CHECK(lab_words("aerosol").in_mm);
  CHECK(lab_words("aerosol").amount == "switches");
}

TEST_CASE(
    "Prints of both labs are judged by the same rule: feedback is within a layer, valves that give too "
    "little leave the open loop far out") {
  const firn::test::Scratch scratch("print-show");
  const auto small = firn::test::small_ice_part(
      {"control.scheme=open_loop", "plant.ice.flow_water_mm3_s=150", "plant.ice.flow_sme_mm3_s=150"});
  const PrintSummary open = printed(small.experiment, small.inputs, scratch / "runs", 0.0);
  CHECK(open.result.tolerance_um == Approx(240.0));
  CHECK(open.result.outcome == "out of tolerance");
  CHECK(open.result.status == kOutOfTolerance);
  const auto kept = runs::RunFolder::open(open.folder).result();
  REQUIRE(kept);
  CHECK(runs::result_text(*kept) == runs::result_text(open.result));
  REQUIRE(kept->part);
  CHECK(kept->part->name.find(".stl") != std::string::npos);
  for (const double side : kept->part->size_mm) CHECK(side > 0.0);
  CHECK(kept->audit == "clean");
  REQUIRE(kept->error);
  CHECK((kept->error->rms_inside_um > 0.0 && kept->error->rms_rim_um > 0.0));
  CHECK(kept->error->rms_um <= std::max(kept->error->rms_inside_um, kept->error->rms_rim_um));
  const auto fed = firn::test::small_ice_part({});
  const PrintSummary smf = printed(fed.experiment, fed.inputs, scratch / "runs", 50.0);
  CHECK(smf.result.tolerance_um == 50.0);
  CHECK(smf.result.status == kOutOfTolerance);  // 50 um is asked too much

  const std::filesystem::path file = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments/cylinder.toml";
  const Experiment inkjet =
      load_experiment(file, {"part.height_mm=0.08", "grid.nx=24", "grid.ny=24", "part.diameter_mm=5"});
  const PrintSummary mpc =
      printed(inkjet, make_inputs(full_product(), inkjet, file.parent_path()), scratch / "runs", 0.0);
  CHECK(within_tolerance(mpc.result) == true);
  CHECK(part_words(*mpc.result.part).starts_with("cylinder, "));
  CHECK(mpc.result.part->size_mm[2] == Approx(0.08));
  REQUIRE(mpc.result.overspill_percent);
  CHECK((*mpc.result.overspill_percent > 0.0 && *mpc.result.overspill_percent < 60.0));
  REQUIRE(mpc.result.outline);
  CHECK(100.0 * mpc.result.outline->overspill == Approx(*mpc.result.overspill_percent));
  CHECK(mpc.result.outline->missing >= 0.0);
  CHECK(1e3 * mpc.result.outline->rms_mm == Approx(mpc.result.error->rms_um));
  CHECK(1e3 * mpc.result.outline->rms_inside_mm == Approx(mpc.result.error->rms_inside_um));
  CHECK(mpc.result.audit == "clean");
  CHECK(mpc.result.status == kOk);
  // A report judges the edge by the same map.
  const report::RunData reported = run_data(full_product(), mpc.folder);
  REQUIRE(reported.layers.back().measured_outline);
  for (const OutlineMetric& m : kOutlineMetrics) {
    CAPTURE(m.name);
    CHECK(mpc.result.outline->cut == reported.layers.back().measured_outline->cut);
    const double told = (*mpc.result.outline).*m.value;
    const double shown = (*reported.layers.back().measured_outline).*m.value;
    CHECK((told == shown || (std::isnan(told) && std::isnan(shown))));
  }
}

TEST_CASE("A print of lines, which fade beside their middle, tells a size and no overspill") {
  const firn::test::Scratch scratch("print-show-lines");
  const std::filesystem::path file =
      std::filesystem::path(FIRN_SOURCE_DIR) / "experiments/aerosol-meander.toml";
  const Experiment lines = load_experiment(file, {"aerosol.layers=1"});
  const PrintSummary s =
      printed(lines, make_inputs(full_product(), lines, file.parent_path()), scratch / "runs", 0.0);
  CHECK(part_words(*s.result.part).starts_with("lines aerosol-meander.json, "));
  CHECK(s.result.error);
  CHECK_FALSE(s.result.overspill_percent);
  CHECK_FALSE(s.result.outline);
  CHECK(print_text(s).find("overspill") == std::string::npos);
}
