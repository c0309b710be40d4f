#include "core/control/mpc/descent.h"

#include <catch2/catch.hpp>

#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

TEST_CASE(
    "descent that looks in single precision first makes the same moves, tries the same number and ends at "
    "the same bytes") {
  std::int64_t moves = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    StripInstance in = random_instance(seed, 4 + int(random.below(20)), 3 + int(random.below(16)), seed % 2);
    const int horizon = 2 + int(seed % 2), layers = 1 + int(random.below(std::uint32_t(horizon)));
    const ErrorKind error = seed % 3 == 0 ? ErrorKind::kSquare : ErrorKind::kAbsolute;
    for (double& h : in.height.cells)
      h -= in.setup.model.layer_height_mm() * random.uniform(0.0, double(layers) - 0.5);
    const std::vector<MaterialMap> materials(std::size_t(horizon), in.materials);
    HorizonObjective plain(in.setup, horizon, 1, error, 1e-7, seed % 2 ? 3.0 : 0.0);
    plain.set_surface(in.height, 1.0, materials);
    std::vector<DropletPattern> plan(std::size_t(horizon), DropletPattern(in.setup.grid));
    for (int n = 0; n < layers; ++n) plan[std::size_t(n)] = random_drops(in, random);
    plain.set_plan(plan);
    HorizonObjective sieved = plain;
    HorizonState field(in.setup, in.height, materials, layers);
    field.set_drops(plan);
    DeltaCache flips(
        field, error == ErrorKind::kSquare ? DeltaCache::Wanted::kSquares : DeltaCache::Wanted::kAbsolute);
    const std::int64_t most = seed % 5 == 0 ? 150 : 1000000;
    const SearchResult a = descend(plain, layers, most), b = descend(sieved, layers, most, &flips);
    INFO("seed " << seed);
    CHECK(a.evaluations == b.evaluations);
    CHECK(a.moves == b.moves);
    CHECK(a.optimal == b.optimal);
    CHECK(plain.value_mm() == sieved.value_mm());
    for (int n = 0; n < horizon; ++n) CHECK(plain.layer(n) == sieved.layer(n));
    moves += a.moves;
  }
  CHECK(moves > 1000);
}
