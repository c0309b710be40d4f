#include "core/motion/jerk_profile.h"

#include <algorithm>
#include <cmath>

#include "core/motion/profile_problem.h"

namespace firn::motion {
namespace {

constexpr double kToBoundary = 0.95;  ///< of the way that slacks and multipliers may go in one step
constexpr double kFirstCentring = 0.3, kLeastCentring = 0.2, kMostCentring = 0.8;
/// The gap is not closed faster than the violation: gap >= this times violation, as shares of the duration.
constexpr double kGapPerViolation = 0.01;

}  // namespace

void solve_profile(const Curve& curve, const MotionRows& rows, const RowGroups& groups,
                   const std::vector<double>& top, const std::vector<double>& bound,
                   const ProfileOptions& options, ProfileWork& work, Profile& out) {
  ProfileProblem problem(curve, rows, groups, top, bound, work);
  const double over_terms = 1.0 / double(problem.terms());
  double centring = kFirstCentring, duration = 0.0;
  out.violation = 0.0;
  for (out.iterations = 0; out.iterations < options.most_iterations; ++out.iterations) {
    const double gap = problem.complementarity();
    const double mu = over_terms * std::max(centring * gap,
                                            std::min(2.0 * gap, kGapPerViolation * out.violation * duration));
    out.violation = problem.assemble(mu);
    duration = problem.duration();
    out.gap = gap / duration;
    if (out.gap + out.violation / 3.0 < options.gap || !problem.solve_step()) break;
    const auto lengths = problem.step_lengths(mu, kToBoundary);
    problem.move(lengths);
    const double shorter = std::min(lengths.primal, lengths.dual);
    centring = std::clamp((1.0 - shorter) * (1.0 - shorter), kLeastCentring, kMostCentring);
  }
  problem.result(out);
}

}  // namespace firn::motion
