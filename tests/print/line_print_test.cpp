// A print of lines in the aerosol lab, in process.
#include <catch2/catch.hpp>
#include <filesystem>

#include "config/include.h"
#include "config/labs.h"
#include "firn/enums.h"
#include "firn/line_plan_t.hpp"
#include "print/labs/print_labs.h"
#include "print/preview/print_preview.h"
#include "print/simulated/memory_print.h"

using namespace firn;

namespace {

const std::filesystem::path kPrintFolder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

Experiment meander(std::vector<std::string> more = {}) {
  return load_experiment(kPrintFolder / "aerosol-meander.toml", more);
}

MemoryPrintReport printed(const Experiment& e, std::vector<line_plan_t>* plans = nullptr) {
  MemoryPrintOptions options;
  options.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    line_plan_t m;
    if (plans && channel == channels::kLinePlan.name && m.decode(bytes.data(), 0, int(bytes.size())) >= 0)
      plans->push_back(std::move(m));
  };
  return print_in_memory(e, make_inputs(e, kPrintFolder), options);
}

}  // namespace

TEST_CASE("A meander is printed to its end, and feedback meets the section that open loop drifts away from",
          "[line]") {
  const MemoryPrintReport open = printed(meander({"control.scheme=open_loop", "plant.aerosol.drift=0.2",
                                                  "plant.aerosol.drift_spread=0"})),
                          closed =
                              printed(meander({"plant.aerosol.drift=0.2", "plant.aerosol.drift_spread=0"}));
  CHECK(open.result.status == 0);
  CHECK(closed.result.status == 0);
  CHECK(closed.result.layers == 6);
  INFO("open " << open.lines.section_rms << ", closed " << closed.lines.section_rms << ", start "
               << closed.lines.worst_start_mm << ", end " << closed.lines.worst_end_mm);
  CHECK(closed.lines.section_rms < 0.03);
  CHECK(open.lines.section_rms > 2.0 * closed.lines.section_rms);
  CHECK(closed.lines.worst_start_mm < 0.05);
  CHECK(closed.lines.worst_end_mm < 0.05);
  CHECK(closed.lines.gaps == 0.0);
}

TEST_CASE("The delays that the lab identifies are the shutter's own with its tail", "[line]") {
  std::vector<line_plan_t> plans;
  printed(meander({"aerosol.layers=3"}), &plans);
  REQUIRE(plans.size() == 4);
  CHECK(PlanDecision(plans.back().decision) == PlanDecision::kEnd);
  // Half of the level is reached where the opening is half: delay + tail ln 2; the start-up blob comes first.
  CHECK(plans[2].open_delay_s == Approx(0.03).margin(0.012));
  CHECK(plans[2].close_delay_s == Approx(0.045 + 0.004).margin(0.012));
}

TEST_CASE("A preview of lines names length, layers and ink", "[line]") {
  const Experiment e = meander();
  const PrintPreview p = preview_print(e, make_inputs(e, kPrintFolder), kPrintFolder);
  CHECK(p.layers == 6);
  CHECK(p.amount == 6 * 40);
  CHECK(p.volume_mm3 == Approx(6 * 40.0 / 3.0 * 0.005));
  CHECK_THAT(preview_text(p),
             Catch::Contains("lines aerosol-meander.json") && Catch::Contains("240 mm of lines"));
}

TEST_CASE("An open loop never changes its way", "[line]") {
  std::vector<line_plan_t> plans;
  printed(meander({"aerosol.layers=3", "control.scheme=open_loop"}), &plans);
  REQUIRE(plans.size() == 4);
  CHECK(plans[1].switch_mm == plans[0].switch_mm);
  CHECK(plans[2].x_mm == plans[0].x_mm);
}
