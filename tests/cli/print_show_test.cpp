// Tests the lines that a print shows at its end.
#include <catch2/catch.hpp>

#include "cli/print_show.h"
#include "config/include.h"
#include "files/json.h"
#include "print/exit_codes.h"
#include "print/labs/print_labs.h"
#include "tests/print/ice_runs.h"

using namespace firn;
using Catch::Contains;

namespace {

PrintSummary over(RunResult result, double rms_um, double tolerance_um, bool asked = false) {
  PrintSummary s;
  s.scheme = "open_loop";
  s.result = std::move(result);
  s.measured = rms_um > 0.0;
  s.rms_um = rms_um;
  s.tolerance_um = tolerance_um;
  s.tolerance_asked = asked;
  return s;
}

const RunResult kDone{"finished", kOk, 30, "the last layer is printed"},
    kDry{"out of tolerance", kOutOfTolerance, 30, "valve_a gives nothing"},
    kStopped{"stopped safely", kSafetyStop, 12, "robot: link lost"};

std::string last_line(const std::string& text) { return text.substr(text.rfind('\n', text.size() - 2) + 1); }

PrintSummary printed(Experiment e, const Blobs& inputs, const std::filesystem::path& runs,
                     double tolerance_um) {
  PrintOptions o;
  o.bus = "in-process";
  o.runs = runs.string();
  o.tolerance_um = tolerance_um;
  return print_experiment(e, inputs, o);
}

}  // namespace

TEST_CASE("The usual tolerance is one nominal layer, in both labs, and none where a print has no target") {
  Experiment e;
  CHECK(usual_tolerance_um(e) == Approx(7.6));
  e.control.scheme = "open_loop";
  CHECK(usual_tolerance_um(e) == Approx(7.6));
  e.control.open_loop.layers = 3;
  CHECK(usual_tolerance_um(e) == 0.0);
  for (const char* scheme : {"pattern", "registration"}) {
    e.control.scheme = scheme;
    CHECK(usual_tolerance_um(e) == 0.0);
  }
  Experiment ice;
  ice.lab.kind = "ice";
  ice.control.scheme = "open_loop";
  CHECK(usual_tolerance_um(ice) == Approx(240.0));
}

TEST_CASE("The last line of a print gives its verdict, and out of tolerance has an exit code of its own") {
  struct Case {
    PrintSummary summary;
    std::optional<bool> within;
    int code;
    std::string line;
  };
  const Case cases[] = {
      {over(kDone, 7.0, 7.6), true, 0,
       "within tolerance: RMS 7.00 um of the last map, at most 7.60 um, one layer"},
      {over(kDone, 80.0, 7.6), false, 4,
       "OUT OF TOLERANCE: RMS 80.00 um of the last map, more than 7.60 um, one layer"},
      {over(kDone, 80.0, 7.6, true), false, 4,
       "OUT OF TOLERANCE: RMS 80.00 um of the last map, more than 7.60 um\n"},
      {over(kDone, 7.0, 7.6, true), true, 0, "within tolerance"},
      {over(kDry, 7.0, 7.6), false, 4, "OUT OF TOLERANCE: valve_a gives nothing"},
      {over(kStopped, 7.0, 7.6, true), std::nullopt, 3, "to go on: firn print --resume"},
      {over(kDone, 0.0, 7.6, true), std::nullopt, 1, "nothing was measured"},
      {over(kDone, 7.0, 0.0), std::nullopt, 0, "run folder"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.line);
    CHECK(within_tolerance(c.summary) == c.within);
    CHECK(exit_code(c.summary) == c.code);
    CHECK_THAT(last_line(print_text(c.summary)), Contains(c.line));
    const auto j = nlohmann::json::parse(print_json(c.summary));
    CHECK(j["status"] == c.code);
    CHECK(j["within_tolerance"].is_null() == !c.within.has_value());
    if (c.within) CHECK(j["within_tolerance"] == *c.within);
  }
}

TEST_CASE(
    "Prints of both labs are judged by the same rule: feedback is within a layer, valves that give too "
    "little leave the open loop far out") {
  const firn::test::Scratch scratch("print-show");
  const auto small = firn::test::small_ice_part(
      {"control.scheme=open_loop", "plant.ice.flow_water_mm3_s=150", "plant.ice.flow_sme_mm3_s=150"});
  const PrintSummary open = printed(small.experiment, small.inputs, scratch / "runs", 0.0);
  CHECK(open.result.status == kOk);
  CHECK(open.tolerance_um == Approx(240.0));
  CHECK(within_tolerance(open) == false);
  CHECK(exit_code(open) == kOutOfTolerance);
  const auto fed = firn::test::small_ice_part({});
  const PrintSummary smf = printed(fed.experiment, fed.inputs, scratch / "runs", 50.0);
  CHECK(smf.tolerance_asked);
  CHECK(within_tolerance(smf) == false);  // 50 um is asked too much
  CHECK(exit_code(smf) == kOutOfTolerance);

  const std::filesystem::path file = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments/cylinder.toml";
  const Experiment inkjet =
      load_experiment(file, {"part.height_mm=0.08", "grid.nx=24", "grid.ny=24", "part.diameter_mm=5"});
  const PrintSummary mpc = printed(inkjet, make_inputs(inkjet, file.parent_path()), scratch / "runs", 0.0);
  CHECK(within_tolerance(mpc) == true);
  CHECK(exit_code(mpc) == kOk);
}
