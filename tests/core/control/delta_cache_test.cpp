#include "core/control/mpc/delta_cache.h"

#include <catch2/catch.hpp>

#include "core/control/mpc/flip_kernel.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control;
using namespace firn::control::mpc;
using namespace firn::test;

namespace {

// Deltas of one flip by itself, from flip_kernel.h.
ObjectiveDeltas alone(const HorizonState& f, int layer, std::size_t p) {
  Flip flip;
  make_flip(f, layer, p, flip);
  ObjectiveDeltas s;
  sums_of(f, layer, p, flip, s);
  return s;
}

HorizonState random_field(const StripInstance& in, int layers, RandomStream& random) {
  HorizonState field(in.setup, in.height, std::vector<MaterialMap>(std::size_t(layers), in.materials),
                     layers);
  std::vector<DropletPattern> plan;
  for (int n = 0; n < layers; ++n) plan.push_back(random_drops(in, random));
  field.set_plan(plan);
  return field;
}

}  // namespace

TEST_CASE(
    "a table of flips holds the bytes of every flip tried by itself, whatever was flipped before, with "
    "vectors of any kind") {
  using Wanted = DeltaCache::Wanted;
  for (std::uint64_t seed = 1; seed <= 36; ++seed) {
    RandomStream random(seed, Purpose::kInstance);
    const int nx = 1 + int(random.below(24)), ny = 1 + int(random.below(14)), layers = 1 + int(seed % 3);
    const StripInstance in = random_instance(seed, nx, ny, seed % 2);
    const Wanted wanted = seed % 4 == 0   ? Wanted::kAbsolute
                          : seed % 4 == 1 ? Wanted::kSquares
                                          : Wanted::kBoth;
    HorizonState field = random_field(in, layers, random), same = field, plain = field;
    DeltaCache widest(field, wanted), portable(same, wanted, DeltaCache::Kernel::kPortable);
    INFO("seed " << seed << ", " << nx << " x " << ny << ", " << layers << " layers");
    for (int round = 0; round < 12; ++round) {
      for (int layer = 0; layer < layers; ++layer)
        for (std::uint32_t c = 0; c < std::uint32_t(nx * ny); ++c) {
          const std::size_t p = field.at(c);
          const ObjectiveDeltas a = widest.sums(layer, p), b = portable.sums(layer, p),
                                s = alone(plain, layer, p);
          for (const ObjectiveDeltas& t : {a, b}) {
            REQUIRE(t.abs_error_mm == (wanted == Wanted::kSquares ? 0.0 : s.abs_error_mm));
            REQUIRE(t.first_mm == (wanted == Wanted::kAbsolute ? 0.0 : s.first_mm));
            REQUIRE(t.second_mm2 == (wanted == Wanted::kAbsolute ? 0.0 : s.second_mm2));
          }
        }
      const int layer = int(random.below(std::uint32_t(layers)));
      const std::size_t p = field.at(random.below(std::uint32_t(nx * ny)));
      widest.flip(layer, p);
      portable.flip(layer, p);
      Flip flip;
      make_flip(plain, layer, p, flip);
      keep_flip(plain, layer, p, flip, alone(plain, layer, p));
      REQUIRE(field.error_mm == plain.error_mm);
      REQUIRE(same.error_mm == plain.error_mm);
      if (round == 7) {
        widest.refresh();
        portable.refresh();
        plain.refresh();
      }
    }
    CHECK(field.second_mm2 == plain.second_mm2);
    CHECK(field.droplets == plain.droplets);
  }
}
