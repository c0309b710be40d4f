#include <catch2/catch.hpp>

#include "core/slice/mesh/slicer.h"
#include "runtime/thread_pool.h"
#include "tests/core/slice/oracles.h"

using namespace firn;
using namespace firn::slice;
using namespace firn::test;

TEST_CASE("1, 2 and 8 threads slice to the same bytes") {
  SampleMesh m = torus(20, 7, 300, 150);  // 90,000 facets: more than one chunk
  m = both(shuffled(m, 5), spheres(12, 2));
  SliceOptions options;
  options.chord_tolerance_mm = 0.01;
  const Sliced one = slice::slice(view(m), {}, options, serially);
  for (const int threads : {2, 8}) {
    const Sliced many = slice::slice(view(m), {}, options, parallel_on(threads));
    CHECK(many.layers == one.layers);
    CHECK(many.defects == one.defects);
    CHECK(many.facts.volume_mm3 == one.facts.volume_mm3);
    CHECK(many.counts.segments == one.counts.segments);
  }
}
