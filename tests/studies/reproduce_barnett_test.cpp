#include <algorithm>
#include <catch2/catch.hpp>

#include "studies/reproduce/reproduce.h"
#include "studies/reproduce/reproduce_parts.h"

using namespace firn;

namespace {

std::vector<ReproducePart> motion_part() {
  return {{"barnett", "motion", "chapter 4", 1, reproduce_barnett_motion}};
}

}  // namespace

TEST_CASE("No row of Barnett's chapter 4 disagrees, and rows and pictures have their names") {
  ReproduceOptions options;
  options.paper = "barnett";
  options.quick = true;
  const auto results = reproduce(options, motion_part());
  REQUIRE(results.size() == 1);
  for (const ReproduceRow& row : results[0].rows) {
    INFO(row.id);
    CHECK(row.id.starts_with("barnett.motion."));
    CHECK(row.verdict() != Verdict::kNotReproduced);
  }
  CHECK(results[0].rows.size() >= 14);
  CHECK(results[0].beside.size() >= 10);
  for (const char* name : {"fig-4-4", "fig-4-7-jerk", "fig-4-8-jerk", "fig-4-9-speed", "fig-4-12-speed",
                           "fig-4-13", "fig-4-16-variable", "fig-4-14-x"})
    CHECK(std::any_of(results[0].pictures.begin(), results[0].pictures.end(),
                      [&](const auto& p) { return p.name == name; }));
}
