// The speed profile's parts against each other: two orders of elimination, two ways to a bound.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/certified/certified.h"
#include "tests/core/motion/random_paths.h"

namespace firn::motion {
namespace {

const MotionLimits kCobra = cobra600_limits();

/// Calls use(curve, rows, groups) for the segments of random paths that are not straight.
template <class Use>
void for_random_curves(int paths, std::uint64_t seed, Use&& use) {
  const auto arm = make_scara(cobra600());
  CertifiedWork work;
  RandomPathMaker maker(seed);
  for (int k = 0; k < paths; ++k) {
    PathInput input;
    const RandomPath path = maker.next();
    input.points = path.points;
    const PlanResult result = plan_certified(input, *arm, kCobra, {}, work);
    Placement place;
    place.configuration = result.configuration;
    for (std::size_t i = 0; i <= result.stops; ++i) {
      const Curve curve = work.segments[i].curve;
      if (curve.straight || curve.cells() < 4) continue;
      MotionRows rows;
      REQUIRE(!compute_rows(curve, *arm, place, 2, rows));
      use(curve, rows, row_groups(kCobra, 2, false));
    }
  }
}

}  // namespace

TEST_CASE("Newton's step from both ends leads to the profile that the step from one end leads to") {
  int curves = 0;
  for_random_curves(20, 31, [&](const Curve& curve, const MotionRows& rows, const RowGroups& groups) {
    SpeedBound bound;
    speed_bound(curve, rows, groups, groups.count, true, bound);
    Profile of[2];
    for (const bool both : {false, true}) {
      ProfileOptions options;
      options.gap = 1e-5;
      options.from_both_ends = both;
      RowGroups order = groups;
      ProfileWork work;
      solve_profile(curve, rows, order, order.count, bound.limit, bound.b, options, work, of[both]);
    }
    double off = 0.0;
    for (std::size_t i = 0; i < of[0].b.size(); ++i)
      off = std::max(off, std::abs(of[1].b[i] - of[0].b[i]) / (of[0].b[i] + 1e-6));
    CHECK(off < 1e-3);
    CHECK(of[0].iterations == of[1].iterations);
    ++curves;
  });
  CHECK(curves > 10);
}

TEST_CASE("A bound that is not exact is above the exact one by a ten-thousandth at most") {
  int curves = 0;
  for_random_curves(20, 32, [&](const Curve& curve, const MotionRows& rows, const RowGroups& groups) {
    SpeedBound exact, close;  // exact ends where low meets high, without a look at the rest: it may be above
    speed_bound(curve, rows, groups, groups.count, true, exact);
    speed_bound(curve, rows, groups, groups.count, false, close);
    double above = 0.0;
    for (std::size_t i = 0; i < exact.b.size(); ++i)
      above = std::max(above, (close.b[i] - exact.b[i]) / (exact.b[i] + 1e-6));
    CHECK(above < 1e-4);
    ++curves;
  });
  CHECK(curves > 10);
}

}  // namespace firn::motion
