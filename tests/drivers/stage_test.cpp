#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"
#include "drivers/stage/stage.h"
#include "tests/drivers/yes_ensemble.h"

using namespace firn;
using namespace firn::drivers;
using firn::drivers::test::YesEnsemble;

namespace {

const std::string kStageTranscripts = std::string(FIRN_SOURCE_DIR) + "/tests/drivers/transcripts/";

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// The stage of the transcripts: slower and smaller than the lab's.
StageOptions small_stage() {
  StageOptions c;
  c.acceleration_mm_s2 = 2000.0;
  c.max_speed_mm_s = 200.0;
  c.x_min_mm = c.y_min_mm = -50.0;
  c.x_max_mm = c.y_max_mm = c.z_max_mm = 50.0;
  c.z_min_mm = -1.0;
  return c;
}

void stage_command(Stage& stage, const std::string& text, std::int64_t now_us, Effects& fx) {
  if (text == "pass") {
    DropletPattern pattern(GridSpec{4, 2, 0.25, 0.5, 0.0, 0.0});
    pattern.at(0, 1) = pattern.at(2, 1) = pattern.at(3, 1) = 1;
    stage.run_pass(pattern, 0, kNotANumber, 0.0, now_us, fx);
  } else if (text == "bad verb") {
    stage.move_to(1.0, kNotANumber, kNotANumber, 0.0, now_us, fx);
  } else {
    FAIL("no command " << text);
  }
}

}  // namespace

TEST_CASE("the stage speaks as the Ensemble cards say, whatever the split of the replies", "[stage]") {
  for (const std::size_t split : {0, 1, 2, 3}) {
    Stage stage(small_stage());
    firn::drivers::test::play(
        stage, kStageTranscripts + "ens_pso_row.txt",
        [&](const std::string& c, std::int64_t t, Effects& fx) { stage_command(stage, c, t, fx); }, split);
  }
}

TEST_CASE(
    "a position outside the host's limits is refused, naming axis, value and limit, and nothing is sent",
    "[stage][I8]") {
  YesEnsemble e(small_stage());
  const auto refused = [&](const std::function<void(std::int64_t, Effects&)>& f, const std::string& text) {
    e.bench.command(f);
    const Result r = e.bench.all<Result>().back();
    CHECK(r.outcome == Outcome::kRefused);
    CHECK(r.code == kLimit);
    CHECK_THAT(r.text, Catch::Contains(text));
    CHECK(e.bench.tx.empty());
    CHECK(e.stage.safe());
  };
  Stage& stage = e.stage;
  refused([&](auto t, auto& fx) { stage.move_to(50.1, 0, 0, 10, t, fx); },
          "axis X: 50.1000 mm is outside [-50.0000, 50.0000] mm");
  refused([&](auto t, auto& fx) { stage.move_to(0, -50.1, 0, 10, t, fx); }, "axis Y: -50.1000 mm");
  refused([&](auto t, auto& fx) { stage.move_to(0, 0, std::numeric_limits<double>::infinity(), 10, t, fx); },
          "axis Z: inf mm");
  refused([&](auto t, auto& fx) { stage.move_to(kNotANumber, kNotANumber, 0, 201, t, fx); },
          "axis Z: speed 201.0000 mm/s is outside (0, 200.0000] mm/s");
  refused([&](auto t, auto& fx) { stage.move_to(0, 0, 0, kNotANumber, t, fx); }, "speed");
  refused([&](auto t, auto& fx) { stage.scan(0, 49, 0, 0.25, 10, 10, t, fx); }, "axis Y: 51.");
  refused([&](auto t, auto& fx) { stage.scan(0, 0, 0, 0.25, 10, 60, t, fx); },
          "more run-up than one pitch; limit 31.6228 mm/s");
  refused([&](auto t, auto& fx) { stage.scan(0, 0, 0, kNotANumber, 10, 10, t, fx); }, "scan pitch");
  DropletPattern pattern(GridSpec{4, 1, 0.25, 0.25, 49.0, 0.0});
  pattern.at(3, 0) = 1;  // x = 49.75 mm: the run-out is beyond the limit
  refused([&](auto t, auto& fx) { stage.run_pass(pattern, 0, kNotANumber, 50, t, fx); },
          "axis X: 50.4750 mm is outside [-50.0000, 50.0000] mm (row 0)");
  refused([&](auto t, auto& fx) { stage.run_pass(pattern, 0, kNotANumber, 1e6, t, fx); }, "axis X: speed");
  DropletPattern fine(GridSpec{4, 1, 0.01, 0.25, 0.0, 0.0});
  fine.at(0, 0) = 1;
  refused([&](auto t, auto& fx) { stage.run_pass(fine, 0, kNotANumber, 50, t, fx); },
          "5000.0 Hz; the jet follows 2000.0 Hz");
}

TEST_CASE("a scan may be as fast as its run-up fits into one pitch", "[stage]") {
  YesEnsemble e(small_stage());
  e.bench.command([&](auto t, auto& fx) { e.stage.scan(0, 0, 0, 0.25, 10, 31.6, t, fx); });
  CHECK(e.bench.all<Result>().empty());
  CHECK(e.stage.busy());
}

TEST_CASE("a pass without droplets is done without a move", "[stage]") {
  YesEnsemble e(small_stage());
  e.bench.command([&](auto t, auto& fx) {
    e.stage.run_pass(DropletPattern(GridSpec{4, 4, 0.25, 0.25, 0, 0}), 0, 1.0, 0, t, fx);
  });
  CHECK(e.bench.all<Result>().back().outcome == Outcome::kDone);
  CHECK(e.bench.all<Result>().back().counted == 0);
  CHECK(e.bench.tx.empty());
}

TEST_CASE("whenever the controller falls silent, no motion and no arming is ever sent twice", "[stage]") {
  DropletPattern pattern(GridSpec{4, 2, 0.25, 0.5, 0.0, 0.0});
  pattern.at(0, 0) = pattern.at(2, 0) = pattern.at(3, 1) = 1;
  for (int silent_after = 0; silent_after < 40; ++silent_after) {
    YesEnsemble e(small_stage());
    e.bench.command([&](auto t, auto& fx) { e.stage.run_pass(pattern, 0, kNotANumber, 0, t, fx); });
    e.log.clear();
    e.swallow_after = silent_after;
    for (int n = 0; n < 300; ++n) {
      e.answer();
      e.bench.advance_to_wake();
    }
    std::map<std::string, int> acts;
    for (const std::string& line : e.log)
      if (line.starts_with("LINEAR") || line.starts_with("HOME")) ++acts[line];
    for (const auto& [line, count] : acts) {
      INFO(line << ", silent after " << silent_after << " lines");
      CHECK(count == 1);
    }
    int arms = 0, fires = 0;
    for (const std::string& line : e.log) {
      arms += line == "PSOCONTROL @0 ARM";
      fires += line.starts_with("LINEAR @0") && line.find("@1") == std::string::npos;
    }
    CHECK(fires <= arms);
    CHECK(arms <= 2);
  }
}

TEST_CASE("the increments of a run add up to the grid points, whatever the rounding", "[stage]") {
  std::uint64_t seed = 3;
  for (int round = 0; round < 50; ++round) {
    const auto random = [&](int n) {
      return int((seed = seed * 6364136223846793005u + 1442695040888963407u) >> 33) % n;
    };
    DropletPattern pattern(GridSpec{1 + random(30), 1 + random(10), 0.05 + 0.001 * random(400), 0.2,
                                    -3.0 + 0.01 * random(500), 1.0});
    for (auto& c : pattern.cells) c = std::uint8_t(random(3));
    RasterParams params;
    params.array_limit = 1 + random(12);
    const int pass = random(2);
    std::size_t drop = 0;
    const auto order = firing_order(pattern, pass);
    for (const RasterRun& run : plan_raster(pattern, pass, params)) {
      REQUIRE(run.first_drop == drop);
      REQUIRE(run.increments.size() <= std::size_t(params.array_limit));
      const double direction = towards_plus_x(run.row) ? 1.0 : -1.0;
      CHECK((run.end_x_mm - run.start_x_mm) * direction > 0);
      double x_mm = std::round(run.start_x_mm * params.counts_per_mm) / params.counts_per_mm;
      for (const std::int64_t counts : run.increments) {
        REQUIRE(counts > 0);
        x_mm += direction * double(counts) / params.counts_per_mm;
        CHECK(std::abs(x_mm - pattern.spec.x_mm(int(order[drop] % std::uint32_t(pattern.spec.nx)))) <
              0.51 / params.counts_per_mm);
        CHECK(int(order[drop] / std::uint32_t(pattern.spec.nx)) == run.row);
        ++drop;
      }
      CHECK((run.end_x_mm - x_mm) * direction >= run_up_mm(params) - 1e-3);
    }
    CHECK(drop == order.size());
  }
}

TEST_CASE("With a lead every pulse comes earlier on its way, in rows of either direction", "[stage]") {
  DropletPattern pattern(GridSpec{12, 4, 0.25, 0.25, -1.0, 2.0});
  for (auto& c : pattern.cells) c = 1;
  RasterParams with, without;
  with.lead_mm = 0.0731;
  const auto early = plan_raster(pattern, 0, with), plain = plan_raster(pattern, 0, without);
  REQUIRE(early.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    const double back_mm = towards_plus_x(plain[n].row) ? -with.lead_mm : with.lead_mm;
    CHECK(early[n].start_x_mm - plain[n].start_x_mm == Approx(back_mm));
    CHECK(early[n].end_x_mm - plain[n].end_x_mm == Approx(back_mm));
    REQUIRE(early[n].increments.size() == plain[n].increments.size());
    for (std::size_t k = 0; k < plain[n].increments.size(); ++k)
      CHECK(std::llabs(early[n].increments[k] - plain[n].increments[k]) <= 1);
  }
}

TEST_CASE(
    "Pulses of droplets at places come at their places, to half a count, each run no faster than the jet "
    "follows",
    "[stage]") {
  RandomStream random(11, Purpose::kTest);
  for (int round = 0; round < 40; ++round) {
    DropletPattern pattern(
        GridSpec{1 + int(random.below(30)), 1 + int(random.below(8)), 0.263256, 0.25, -3.0, 1.0});
    for (auto& c : pattern.cells) c = std::uint8_t(random.below(3));
    Placement placement{OffsetTable({round % 2 ? OffsetKind::kX : OffsetKind::kGrid, 4, 3}),
                        OffsetMap(pattern.spec)};
    for (auto& c : placement.map.cells) c = std::uint8_t(random.below(std::uint32_t(placement.table.size())));
    RasterParams params;
    params.speed_mm_s = 150.0;
    params.lead_mm = round % 3 ? 0.0 : 0.0731;
    params.max_rate_hz = 2000.0;
    if (round % 4 == 0) placement.apart_mm = params.speed_mm_s / (kRateShare * params.max_rate_hz);
    std::size_t drop = 0;
    bool slower = false;
    double last_y_mm = -1e9;
    for (const RasterRun& run : plan_raster(pattern, 0, params, placement)) {
      CHECK(run.first_drop == drop);
      const bool plus = run.end_x_mm > run.start_x_mm;
      double x_mm = std::round(run.start_x_mm * params.counts_per_mm) / params.counts_per_mm;
      double before_mm = 0.0;
      const auto order = firing_order(pattern, 0, placement);
      for (std::size_t k = 0; k < run.increments.size(); ++k, ++drop) {
        x_mm += (plus ? 1.0 : -1.0) * double(run.increments[k]) / params.counts_per_mm;
        const std::uint32_t c = order[drop];
        const StagePlace place = stage_place(pattern.spec, int(c % std::uint32_t(pattern.spec.nx)), run.row,
                                             placement.of(c), {.lead_mm = params.lead_mm}, plus);
        CHECK(std::abs(x_mm - place.x_mm) < 0.51 / params.counts_per_mm);
        CHECK(run.y_mm == place.y_mm);
        if (k > 0) CHECK(std::abs(x_mm - before_mm) >= run.speed_mm_s / params.max_rate_hz);
        before_mm = x_mm;
      }
      CHECK(run.y_mm >= last_y_mm);
      last_y_mm = run.y_mm;
      CHECK(run.speed_mm_s <= params.speed_mm_s);
      slower = slower || run.speed_mm_s < params.speed_mm_s;
      RasterParams own = params;
      own.speed_mm_s = run.speed_mm_s;
      CHECK(std::abs(run.end_x_mm - x_mm) >= run_up_mm(own) - 1e-3);
    }
    CHECK(drop == firing_order(pattern, 0).size());
    if (placement.apart_mm > 0.0) CHECK_FALSE(slower);
  }
}

TEST_CASE(
    "Of a slower run and two runs over a row the pass takes the quicker, and neither without near droplets",
    "[stage]") {
  const auto apart_of = [](int cells, double speed_mm_s, OffsetKind kind) {
    DropletPattern pattern(GridSpec{cells, 3, 0.263256, 0.25, 0.0, 0.0}, 1);
    Placement placement{OffsetTable({kind, 8, 1}), OffsetMap(pattern.spec)};
    for (int c = 0; c < int(pattern.size()) && kind != OffsetKind::kNone; ++c)
      placement.map.cells[std::size_t(c)] = std::uint8_t(c % 2 ? 1 : 8);  // 1/8 of the pitch apart, then 15/8
    RasterParams params;
    params.speed_mm_s = speed_mm_s;
    params.acceleration_mm_s2 = 5000.0;
    params.max_rate_hz = 2000.0;
    const double apart_mm = quicker_apart_mm(pattern, params, placement);
    placement.apart_mm = apart_mm;
    const double chosen_s = raster_time_s(plan_raster(pattern, 0, params, placement), params);
    placement.apart_mm = apart_mm > 0.0 ? 0.0 : speed_mm_s / (kRateShare * params.max_rate_hz);
    CHECK(chosen_s <= raster_time_s(plan_raster(pattern, 0, params, placement), params));
    return apart_mm;
  };
  CHECK(apart_of(20, 150.0, OffsetKind::kX) == 0.0);
  CHECK(apart_of(800, 300.0, OffsetKind::kX) == Approx(300.0 / (kRateShare * 2000.0)));
  CHECK(apart_of(800, 50.0, OffsetKind::kX) == 0.0);
  CHECK(apart_of(800, 300.0, OffsetKind::kNone) == 0.0);
}

TEST_CASE("the plan time of a move is that of the trapezoid", "[stage]") {
  CHECK(move_time_s(10.0, 50.0, 2000.0) == Approx(10.0 / 50.0 + 50.0 / 2000.0));
  CHECK(move_time_s(-0.5, 50.0, 2000.0) == Approx(2.0 * std::sqrt(0.5 / 2000.0)));
  CHECK(move_time_s(1.25, 50.0, 2000.0) == Approx(2.0 * std::sqrt(1.25 / 2000.0)));  // where the two meet
}
