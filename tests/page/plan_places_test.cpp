// The frame of a plan: droplets, and where they land in their cells.
#include <catch2/catch.hpp>

#include <cstring>

#include "config/experiment.h"
#include "core/grid/decision.h"
#include "core/grid/offsets.h"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "page/run_maps.h"

using namespace firn;
using namespace firn::page;

namespace {

constexpr GridSpec kPlanGrid{3, 2, 0.25, 0.25, 0.0, 0.0};

Experiment with_places(OffsetKind kind) {
  Experiment e;
  e.grid = kPlanGrid;
  e.actuation.offsets = kind;
  e.actuation.positions_x = e.actuation.positions_y = 2;
  return e;
}

// The frame of the plan for layer 1 with these droplets and places.
std::vector<std::byte> plan_frame(const Experiment& e, const std::vector<std::int8_t>& drops,
                                  const std::vector<std::int8_t>& places) {
  layer_plan_t plan{};
  plan.layer = 1;
  plan.decision = std::int8_t(PlanDecision::kPrint);
  plan.grid = to_message(kPlanGrid);
  plan.n = std::int32_t(drops.size());
  plan.drops = drops;
  plan.passes = 2;
  plan.n_offset = std::int32_t(places.size());
  plan.offset = places;
  std::vector<std::byte> bytes(std::size_t(plan.getEncodedSize()));
  plan.encode(bytes.data(), 0, int(bytes.size()));
  RunMaps maps("nowhere", e, {}, [&](const runs::Place&) { return bytes; });
  maps.take(channels::kLayerPlan.name, bytes, {});
  return maps.frame({Surface::kPlanned, 0}).value();
}

std::uint32_t flags_of(const std::vector<std::byte>& frame) {
  std::uint32_t flags = 0;
  std::memcpy(&flags, frame.data() + 20, sizeof flags);
  return flags;
}

std::vector<float> values_in(const std::vector<std::byte>& frame) {
  std::vector<float> values((frame.size() - kMapHeaderBytes) / sizeof(float));
  std::memcpy(values.data(), frame.data() + kMapHeaderBytes, values.size() * sizeof(float));
  return values;
}

}  // namespace

TEST_CASE("A plan's frame has the droplets of its cells, and behind them where these land") {
  const Experiment e = with_places(OffsetKind::kGrid);
  const OffsetTable table(e.actuation);
  const std::vector<std::int8_t> drops{1, 0, 2, 1, 1, 0}, places{0, 1, 2, 3, 4, 0};
  const std::vector<std::byte> frame = plan_frame(e, drops, places);
  CHECK(flags_of(frame) == (kMapDroplets | kMapPlaces));
  const std::vector<float> values = values_in(frame);
  REQUIRE(values.size() == 18);
  for (std::size_t c = 0; c < 6; ++c) {
    CHECK(values[c] == float(drops[c]));
    CHECK(values[6 + c] == float(table[places[c]].x));
    CHECK(values[12 + c] == float(table[places[c]].y));
  }
}

TEST_CASE("A plan whose droplets all land in the middle has no places in its frame") {
  const std::vector<std::byte> frame = plan_frame(with_places(OffsetKind::kGrid), {1, 0, 2, 1, 1, 0}, {});
  CHECK(flags_of(frame) == kMapDroplets);
  CHECK(values_in(frame).size() == 6);
}

TEST_CASE("A plan with a place that the lab does not have is shown without places") {
  const std::vector<std::byte> frame =
      plan_frame(with_places(OffsetKind::kX), {1, 0, 2, 1, 1, 0}, {0, 0, 0, 40, 0, 0});
  CHECK(flags_of(frame) == kMapDroplets);
}
