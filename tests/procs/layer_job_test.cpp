// LayerJob's report of a pass in which a stop disarmed the jet before the stage's last pulse.
#include "procs/scheduler/layer_job.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>

#include "core/grid/device.h"
#include "core/grid/random.h"
#include "lcmtypes/convert.h"

using namespace firn;

namespace {

layer_plan_t plan_of(int nx, int ny) {
  layer_plan_t plan{};
  plan.layer = 1;
  plan.passes = 1;
  plan.grid = to_message(GridSpec{.nx = nx, .ny = ny, .pitch_x_mm = 0.2, .pitch_y_mm = 0.2});
  plan.n = nx * ny;
  plan.drops.assign(std::size_t(plan.n), 1);
  return plan;
}

}  // namespace

TEST_CASE("droplets are reported as done only if the jet was armed when the stage triggered them") {
  RandomStream random(1, Purpose::kTest);
  constexpr std::int64_t kSpacing_us = 10'000;
  int doubts = 0, sure = 0;
  for (int n = 0; n < 500; ++n) {
    LayerJob job(plan_of(9, 7));
    const std::int64_t pulses = std::int64_t(random.below(64)), first_us = 1'000'000;
    const std::int64_t last_us = first_us + std::max<std::int64_t>(0, pulses - 1) * kSpacing_us;
    answer_t stage{}, jet{};
    stage.outcome = std::int8_t(pulses == 63  ? Outcome::kDone
                                : pulses == 0 ? Outcome::kNone
                                              : Outcome::kFailed);
    stage.counted = stage.unknown_from = stage.unknown_to = pulses;
    stage.expected = 63;
    stage.header.utime_us = last_us + std::int64_t(random.below(200'000));
    if (random.below(2)) stage.until_utime_us = last_us + std::int64_t(random.below(20'000));
    jet.outcome = std::int8_t(Outcome::kDone);
    jet.counted = -1;
    jet.until_utime_us = first_us - 100'000 + std::int64_t(random.below(1'200'000));
    const std::int64_t obeyed = std::clamp<std::int64_t>(
        (jet.until_utime_us - first_us) / kSpacing_us + (jet.until_utime_us >= first_us), 0, pulses);
    const deposition_report_t r = job.settle(stage, jet, 1e6 / double(kSpacing_us));
    CAPTURE(pulses, obeyed, r.unknown_from, r.unknown_to);
    CHECK(r.unknown_from <= obeyed);
    CHECK(r.unknown_to >= obeyed);
    CHECK(r.unknown_to == pulses);
    CHECK(job.in_doubt() == (r.unknown_to > r.unknown_from));
    CHECK((r.outcome == std::int8_t(Outcome::kUnknown)) == job.in_doubt());
    ++(job.in_doubt() ? doubts : sure);
  }
  CHECK(doubts > 100);
  CHECK(sure > 100);
}

TEST_CASE("a jet that was armed to the end of its pass puts no droplet in doubt") {
  LayerJob job(plan_of(9, 7));
  answer_t stage{}, jet{};
  stage.outcome = std::int8_t(Outcome::kFailed);
  stage.counted = stage.unknown_from = stage.unknown_to = 20;
  stage.header.utime_us = stage.until_utime_us = 2'000'000;
  jet.outcome = std::int8_t(Outcome::kDone);
  const deposition_report_t r = job.settle(stage, jet, 100.0);
  CHECK(r.unknown_from == 20);
  CHECK(r.unknown_to == 20);
  CHECK(job.remaining() == 43);
}
