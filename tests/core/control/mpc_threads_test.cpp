// Layers and bounds on the pool's threads: the bytes of one thread.
#include <catch2/catch.hpp>

#include "core/control/mpc/bound/bound.h"
#include "core/control/mpc/layer/layer_solver.h"
#include "core/control/mpc/layer/strip_dp.h"
#include "core/control/mpc/mpc.h"
#include "runtime/thread_pool.h"
#include "tests/core/control/strip_instances.h"

using namespace firn;
using namespace firn::control::mpc;

TEST_CASE("Strips, layers and bounds are the same bytes on one, two and five threads") {
  const test::StripInstance in = test::random_instance(41, 24, 300, false);
  struct Answer {
    DropletPattern strips, layer;
    std::vector<float> multipliers;
    double bound_mm;
  };
  const auto answer = [&](int threads) {
    const ParallelFor parallel = parallel_on(threads);
    LayerProblem a(in.setup, in.height, in.materials), b = a;
    for (int rows = 2; rows <= 3; ++rows) sweep_strips(a, {rows, 50}, parallel);
    solve_layer(b, {2, 1, 2, 0.0}, parallel);
    LowerBound bound = lower_bound(in.setup, in.height, in.materials, 0.0, {2, 3, 0.0}, parallel);
    return Answer{a.drops(in.setup.grid), b.drops(in.setup.grid), std::move(bound.multipliers),
                  bound.total_mm};
  };
  const Answer one = answer(1);
  for (const int threads : {2, 5}) {
    const Answer other = answer(threads);
    CHECK(other.strips == one.strips);
    CHECK(other.layer == one.layer);
    CHECK(other.multipliers == one.multipliers);
    CHECK(other.bound_mm == one.bound_mm);
  }
}

TEST_CASE("A decision is the same bytes on one, two and five threads, for one layer and three, any alpha") {
  const test::StripInstance in = test::random_instance(17, 60, 90, false);
  struct Case {
    control::MpcMethod method;
    int horizon;
    double alpha;
  };
  for (const Case& c :
       {Case{control::MpcMethod::kStripDp, 1, 1.0}, Case{control::MpcMethod::kCertified, 1, 1.0},
        Case{control::MpcMethod::kCertified, 1, 0.7}, Case{control::MpcMethod::kStripDp, 2, 1.0}}) {
    control::ControlOptions o;
    o.mpc.method = c.method;
    o.mpc.horizon = c.horizon;
    o.mpc.alpha = {{1, c.alpha}};
    o.mpc.anneal_sweeps = 3;
    const auto decision = [&](int threads) {
      const auto scheme = control::make_controller(in.setup, o);
      scheme->use_threads(parallel_on(threads));
      return scheme->decide({in.height, 0});
    };
    const control::Decision one = decision(1);
    CHECK(one.drops.total() > 0);
    for (const int threads : {2, 5}) {
      const control::Decision other = decision(threads);
      CHECK(other.drops == one.drops);
      CHECK(other.objective_mm == one.objective_mm);
      CHECK(other.iterations == one.iterations);
    }
  }
}
