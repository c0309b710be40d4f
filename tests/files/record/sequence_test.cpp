#include "files/record/sequence.h"

#include <catch2/catch.hpp>

#include "tests/files/record/scratch.h"

using firn::record::SequenceMap;
using firn::test::Random;

TEST_CASE("What stands behind a place is found as by looking at every piece") {
  Random random{31};
  for (std::size_t n = 0; n < 40; ++n) {
    SequenceMap map;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> pieces;
    for (std::size_t i = 0; i < n; ++i) {
      pieces.emplace_back(random.below(30), 1 + random.below(1000));  // numbers repeat
      map.add(pieces.back().first, pieces.back().second);
    }
    map.finish();
    for (int query = 0; query < 200; ++query) {
      const std::uint64_t from = random.below(32), to = random.below(32), offset = random.below(1000);
      bool found = false;
      for (const auto& [number, at] : pieces) found = found || (number >= from && number < to && at > offset);
      REQUIRE(map.any_behind(from, to, offset) == found);
    }
  }
}
