#include "lcmtypes/validate.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "firn/enums.h"
#include "firn/gas_flow_t.hpp"
#include "tests/lcmtypes/limit_rows.h"
#include "tests/lcmtypes/samples.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

template <class M>
std::optional<std::string> judge(const std::string& channel, const M& message) {
  const ChannelInfo* info = find_channel(channel);
  REQUIRE(info);
  return validate(*info, encode(message));
}

template <class M, class Change>
std::string refused(const std::string& channel, M message, Change change) {
  change(message);
  const auto said = judge(channel, message);
  REQUIRE(said);
  CHECK_THAT(*said, Catch::Matchers::StartsWith(channel + ": byte "));
  return *said;
}

}  // namespace

TEST_CASE("Every row of the limits names a member, and every number has a limit") {
  CHECK(unmatched_limits() == std::vector<std::string>{});
  CHECK(unlimited_members() == std::vector<std::string>{});
}

TEST_CASE("Messages within their limits pass") {
  CHECK(judge("HEIGHT_MAP", some_height_map(40, 40)) == std::nullopt);
  CHECK(judge("LAYER_PLAN", some_layer_plan(7, 3)) == std::nullopt);
  CHECK(judge("STAGE_COMMAND", some_pass(7, 3)) == std::nullopt);
  CHECK(judge("HEARTBEAT_JET", some_heartbeat()) == std::nullopt);
  stage_command_t home{};
  home.header = some_header();
  home.verb = 4;
  CHECK(judge("STAGE_COMMAND", home) == std::nullopt);
  layer_plan_t end = some_layer_plan(7, 3);
  end.decision = 1;
  CHECK(judge("LAYER_PLAN", end) == std::nullopt);
  end.n = 0;
  end.drops.clear();
  end.grid = {};
  CHECK(judge("LAYER_PLAN", end) == std::nullopt);
}

TEST_CASE("A value outside its limit is refused with channel, byte, member, value and limit") {
  const auto map = some_height_map(5, 4);
  CHECK(refused("HEIGHT_MAP", map, [](auto& m) { m.grid.nx = 4; }) ==
        "HEIGHT_MAP: byte 36: n = 20 is not grid.nx * grid.ny = 16");
  CHECK(refused("HEIGHT_MAP", map, [](auto& m) { m.layer = -1; }) ==
        "HEIGHT_MAP: byte 40: layer = -1 is outside 0..1000000");
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.grid.pitch_y_mm = 0; }),
             Contains("grid.pitch_y_mm = 0 is outside above 0 up to 100"));
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.grid.pitch_x_mm = NAN; }),
             Contains("grid.pitch_x_mm = nan"));
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.height_mm[17] = INFINITY; }),
             Contains("height_mm[17] = inf is outside"));
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.height_mm[2] = -2e5F; }),
             Contains("height_mm[2] = -200000"));
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.quality[19] = 3; }),
             Contains("quality[19] = 3 is outside 0..2"));
  CHECK_THAT(refused("HEIGHT_MAP", map, [](auto& m) { m.header.seq = 0; }),
             Contains("header.seq = 0 is outside 1.."));

  const auto plan = some_layer_plan(5, 4);
  CHECK_THAT(refused("LAYER_PLAN", plan, [](auto& m) { m.drops[11] = -1; }),
             Contains("drops[11] = -1 is outside 0..127"));
  CHECK_THAT(refused("LAYER_PLAN", plan, [](auto& m) { m.drops[11] = 4; }),
             Contains("drops[11] = 4 is above passes = 3"));
  CHECK_THAT(refused("LAYER_PLAN", plan, [](auto& m) { m.decision = 3; }),
             Contains("decision = 3 is outside 0..2"));
  CHECK_THAT(refused("LAYER_PLAN", plan, [](auto& m) { m.objective_mm = NAN; }),
             Contains("objective_mm = nan is not finite"));
  CHECK_THAT(refused("LAYER_PLAN", plan, [](auto& m) { m.reason.assign(2'000'000, 'x'); }),
             Contains("reason is a text of 2000001 bytes"));

  const auto pass = some_pass(5, 4);
  CHECK_THAT(refused("STAGE_COMMAND", pass, [](auto& m) { m.verb = 6; }),
             Contains("verb = 6 is outside 1..5"));
  CHECK_THAT(refused("STAGE_COMMAND", pass, [](auto& m) { m.speed_mm_s = 0; }),
             Contains("speed_mm_s = 0 is outside above 0 up to 1000 (while verb = 1)"));
  CHECK_THAT(refused("STAGE_COMMAND", pass, [](auto& m) { m.verb = 3; }),
             Contains("n = 20 is outside 0..0 (while verb = 3)"));
  CHECK_THAT(refused("STAGE_COMMAND", pass, [](auto& m) { m.grid.ny = 5; }), Contains("n = 20 is not"));

  lamp_command_t lamp{};
  lamp.header = some_header();
  lamp.verb = 1;
  lamp.iris_percent = 50;
  lamp.exposure_s = 1;
  CHECK_FALSE(judge("LAMP_COMMAND", lamp));
  CHECK_THAT(refused("LAMP_COMMAND", lamp, [](auto& m) { m.exposure_s = 3601; }),
             Contains("exposure_s = 3601 is outside 0..3600"));
  CHECK_THAT(refused("LAMP_COMMAND", lamp, [](auto& m) { m.iris_percent = 0; }),
             Contains("iris_percent = 0 is outside 1..100"));

  answer_t answer{};
  answer.header = some_header();
  answer.unknown_from = 5;
  answer.unknown_to = 4;
  CHECK_THAT(*judge("ANSWER_STAGE", answer), Contains("unknown_from = 5 is above unknown_to = 4"));
}

TEST_CASE("A message of another type, or none, is refused by name") {
  CHECK(*judge("HEIGHT_MAP", some_layer_plan(2, 2)) ==
        "HEIGHT_MAP: byte 0: fingerprint is not height_map_t's but layer_plan_t's");
  const ChannelInfo& map = *find_channel("HEIGHT_MAP");
  CHECK(*validate(map, {}) == "HEIGHT_MAP: byte 0: 0 bytes are no message");
  const std::vector<std::byte> noise(100, std::byte{0x5a});
  CHECK_THAT(*validate(map, noise), Contains("fingerprint is not height_map_t's"));
  CHECK_THAT(*validate("X", "no_such_t", noise), Contains("type 'no_such_t' is unknown"));
  const auto whole = encode(some_height_map(5, 4));
  CHECK_THAT(*validate(map, std::span(whole).first(whole.size() - 1)),
             Contains("HEIGHT_MAP: byte ") && Contains("quality: array size n = 20"));
}

TEST_CASE("The fast checks of whole arrays agree with each element's own limit") {
  height_map_t map = some_height_map(13, 7);
  const float tests[] = {
      0,    -0.0F,    1e5F,      -1e5F, std::nextafterf(1e5F, 2e5F), -std::nextafterf(1e5F, 2e5F), NAN,
      -NAN, INFINITY, -INFINITY, 1e-40F};
  for (std::size_t at = 0; at < 91; at += 9)
    for (const float v : tests) {
      map.height_mm[at] = v;
      const bool fine = std::isnan(v) || (v >= -1e5F && v <= 1e5F);
      CHECK(judge("HEIGHT_MAP", map).has_value() != fine);
      map.height_mm[at] = 0;
    }
  layer_plan_t plan = some_layer_plan(13, 7);
  for (int passes : {0, 1, 3, 127}) {
    plan.passes = passes;
    std::fill(plan.drops.begin(), plan.drops.end(), std::int8_t(0));
    for (std::size_t at = 0; at < 91; at += 5)
      for (int v = -128; v < 128; ++v) {
        plan.drops[at] = std::int8_t(v);
        if (judge("LAYER_PLAN", plan).has_value() != (v < 0 || v > passes))
          FAIL("drops[" << at << "] = " << v << " passes " << passes);
        plan.drops[at] = 0;
      }
  }
}

TEST_CASE("Any finite pair of doubles passes where nothing else is asked, and no other") {
  gas_flow_t flow{};
  flow.header = some_header();
  const double most = std::numeric_limits<double>::max(), infinite = std::numeric_limits<double>::infinity();
  for (const double v : {0.0, -0.0, most, -most, infinite, -infinite, double(NAN), 5e-324})
    for (double& place : flow.sccm) {
      place = v;
      CHECK(judge("GAS_FLOW", flow).has_value() != std::isfinite(v));
      place = 0.0;
    }
}

TEST_CASE("Every end of a run may be told, also a part out of tolerance") {
  for (const RunOutcome outcome : {RunOutcome::kFinished, RunOutcome::kEndedEarly, RunOutcome::kStoppedSafely,
                                   RunOutcome::kWaitsForOperator, RunOutcome::kOutOfTolerance}) {
    run_end_t end{};
    end.header = some_header();
    end.outcome = std::int8_t(outcome);
    CHECK(judge("RUN_END", end) == std::nullopt);
  }
}
