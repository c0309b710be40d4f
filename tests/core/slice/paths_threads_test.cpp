#include <catch2/catch.hpp>

#include "core/slice/paths/path_plan.h"
#include "core/slice/support/scaffold.h"
#include "runtime/thread_pool.h"
#include "tests/core/slice/outlines.h"

namespace firn::slice {
namespace {

TEST_CASE("Scaffold is the same for any number of threads") {
  std::vector<geometry::Region> part;
  for (std::uint64_t k = 0; k < 80; ++k) part.push_back(outlines::blob(k / 3));
  for (const Support kind : {Support::kFull, Support::kOverhang}) {
    const SupportOptions options{.kind = kind};
    const std::vector<geometry::Region> one = scaffold_regions(part, 2500, options, 0.05);
    for (const int threads : {2, 8})
      CHECK(scaffold_regions(part, 2500, options, 0.05, parallel_on(threads)) == one);
  }
}

TEST_CASE("Paths are the same for any number of threads") {
  std::vector<LayerPaths> one;
  for (const int threads : {1, 2, 8}) {
    std::vector<LayerPaths> layers(12);
    parallel_on(threads)(12, [&](int k) {
      const LayerRegions regions{
          k + 1, (k + 1) * 2500, 2500, {outlines::blob(std::uint64_t(k)), outlines::gear()}};
      layers[std::size_t(k)] = plan_layer(regions, {});
    });
    if (threads == 1) one = layers;
    CHECK(layers == one);
  }
}

}  // namespace
}  // namespace firn::slice
