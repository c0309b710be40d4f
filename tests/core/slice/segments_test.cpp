// The store between cutting and linking.
#include "core/slice/segments.h"

#include <catch2/catch.hpp>

#include <vector>

#include "core/grid/random.h"
#include "core/slice/placement.h"

using namespace firn;
using namespace firn::slice;

TEST_CASE("Segments of any length come back as they were put in, layer by layer and in order") {
  constexpr std::size_t kLayers = 3, kSegments = 3000;
  // Steps about the largest that a record holds, and ends as far apart as coordinates may be.
  constexpr std::int32_t kSteps[] = {0, 1, -1, 0x7ffe, 0x7fff, 0x8000, -0x7ffe, -0x7fff, -0x8000, -0x8001, 0xffff, -0x10000, 1 << 20, -(1 << 20)};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    const auto below = [&](std::size_t n) { return std::size_t(random.uniform() * double(n)); };
    SegmentLane lane(kLayers);
    std::vector<Segment> put[kLayers];
    for (std::size_t n = 0; n < kSegments; ++n) {
      const std::size_t layer = below(kLayers);
      Segment s;
      s.from_edge = std::uint32_t(below(std::size_t(1) << 32)), s.to_edge = std::uint32_t(below(std::size_t(1) << 32));
      s.from = {std::int32_t(below(2'000'001)) - 1'000'000, std::int32_t(below(2'000'001)) - 1'000'000};
      s.to = {s.from.x + kSteps[below(std::size(kSteps))], s.from.y + kSteps[below(std::size(kSteps))]};
      if (below(50) == 0) s.from = {-kMaxUnits, kMaxUnits}, s.to = {kMaxUnits, -kMaxUnits};
      put[layer].push_back(s);
      lane.add(layer, s);
    }
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      REQUIRE(lane.most(layer) >= put[layer].size());
      std::vector<Segment> got(lane.most(layer));
      got.resize(std::size_t(lane.copy(layer, got.data()) - got.data()));
      REQUIRE(got == put[layer]);
    }
  }
}
