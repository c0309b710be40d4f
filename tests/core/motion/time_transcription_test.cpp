// The planner's durations against the optimum on the same curve by direct transcription.
#include <catch2/catch.hpp>

#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "tests/core/motion/sampled_curves.h"
#include "tests/core/motion/time_transcription.h"

namespace firn::motion {
namespace {

struct Compared {
  double planned_s = 0.0, optimum_s = 0.0, bound_s = 0.0;
};

Compared compare(const std::vector<Point2>& points, Point2 origin, const PlanOptions& options) {
  static const auto arm = make_scara(cobra600());
  static const MotionLimits limits = cobra600_limits();
  CertifiedWork work;
  PathInput input;
  input.points = points;
  input.origin = origin;
  const PlanResult plan = plan_certified(input, *arm, limits, options, work);
  Compared out{plan.continuous_s, 0.0, plan.trajectory.certificate.lower_bound_s};
  for (std::size_t k = 0; k <= plan.stops; ++k) {
    const double best =
        TimeTranscription(work.segments()[k], limits, 325.0, 275.0, plan.configuration.elbow).minimum_time(2);
    REQUIRE(best > 0.0);
    out.optimum_s += best;
  }
  return out;
}

}  // namespace

TEST_CASE(
    "Direct transcription finds the closed form of a straight line, and the optimum known of Fig. 4-2") {
  const double line = 100.0, v = 125.0, a = 500.0, j = 4000.0;
  const Compared straight = compare({{0.0, 0.0}, {line, 0.0}}, {350.0, 50.0}, {});
  CHECK(straight.optimum_s == Approx(line / v + v / a + a / j).epsilon(5e-4));
  const Compared path = compare(thesis::fig_4_2(), thesis::kWellPlaced, {});
  CHECK(path.optimum_s == Approx(5.165).epsilon(2e-3));
  CHECK(path.planned_s < 1.02 * path.optimum_s);
  CHECK(path.bound_s < path.optimum_s);
}

TEST_CASE(
    "The fast tier is within 5 % of the optimum on its own curve, 2 % in the mean, and the bound is below "
    "it") {
  double sum = 0.0;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    INFO(kCurveKind[kind]);
    PlanOptions options;
    options.tolerance_mm = kind % 2 ? 0.05 : 0.0;
    const Compared c = compare(sampled(random_curve(kind, 5), 0.4, 9), {400.0, 0.0}, options);
    CHECK(c.planned_s < 1.05 * c.optimum_s);
    CHECK(c.planned_s > 0.999 * c.optimum_s);
    CHECK(c.bound_s < c.optimum_s);
    sum += c.planned_s / c.optimum_s;
  }
  CHECK(sum < 1.02 * kCurveKinds);
}

}  // namespace firn::motion
