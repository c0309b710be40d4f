#include <catch2/catch.hpp>

#include <set>
#include <tuple>

#include "core/grid/random.h"
#include "core/slice/death_queue.h"

namespace firn::slice::wavefront {

// Against an ordered set, with deaths that follow from others and many at one distance.
TEST_CASE("Deaths are told in the order of their distances, those of one distance by their pieces, whatever is added on the way") {
  RandomStream random(74, Purpose::kTest);
  DeathQueue queue;
  for (int trial = 0; trial < 60; ++trial) {
    const double from = random.uniform(0, 100), to = from + random.uniform(1e-3, 5000), grain = trial % 3 ? (to - from) / 7 : 0;
    std::set<std::tuple<double, std::int32_t, std::uint32_t>> expected;
    std::uint32_t stamp = 0;
    const auto add = [&](double since) {
      double d = random.uniform(since, to);
      if (grain > 0) d = std::max(since, from + grain * double(int((d - from) / grain)));
      if (random.uniform(0, 1) < 0.05) d = to;
      const auto piece = std::int32_t(random.uniform(0, 50));
      queue.add({d, piece, ++stamp});
      expected.insert({d, piece, stamp});
    };
    const int begun = int(random.uniform(1, 400));
    queue.begin(from, to, std::size_t(begun));
    for (int i = 0; i < begun; ++i) add(from);
    Death death{};
    for (int told = 0; queue.next(death); ++told) {
      REQUIRE(!expected.empty());
      const auto [d, piece, of] = *expected.begin();
      CHECK(death.d == d);
      CHECK(death.piece == piece);
      expected.erase({death.d, death.piece, death.stamp});
      if (told < 2 * begun)
        for (int more = int(random.uniform(0, 2.2)); more > 0; --more) add(death.d);
    }
    CHECK(expected.empty());
  }
}

}  // namespace firn::slice::wavefront
