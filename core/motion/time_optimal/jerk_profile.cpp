#include "core/motion/time_optimal/jerk_profile.h"

#include <algorithm>
#include <cmath>

#include "core/motion/time_optimal/profile_problem.h"

namespace firn::motion {
namespace {

constexpr double kToBoundary = 0.96;  ///< of the way that slacks and multipliers may go in one step
constexpr double kFirstCentring = 0.34, kLeastCentring = 0.065, kMostCentring = 0.9;
/// The gap is not closed faster than the violation: gap >= this times violation, as shares of the duration.
constexpr double kGapPerViolation = 0.023;
/// On long motions a relative gap would allow a visible loss near a rest: from here on the gap is absolute.
constexpr double kLongS = 3.0;
/// Inactive groups are checked when gap and violation are first below kEarly, and at the end.
constexpr double kEarly = 0.1, kEarlyRatio = 1.0, kLateRatio = 1.0;

}  // namespace

void solve_profile(const Curve& curve, const MotionRows& rows, RowGroups& groups, int active,
                   const std::vector<double>& top, const std::vector<double>& bound,
                   const ProfileOptions& options, ProfileWork& work, Profile& out, TimeGradient* gradient) {
  ProfileProblem problem(curve, rows, groups, active, top, bound, work);
  bool looked = false;
  double centring = kFirstCentring, duration = 0.0;
  out.violation = 0.0;
  for (out.iterations = 0; out.iterations < options.most_iterations; ++out.iterations) {
    const double gap = problem.complementarity();
    const double mu =
        1.0 / double(problem.terms()) *
        std::max(centring * gap, std::min(2.0 * gap, kGapPerViolation * out.violation * duration));
    out.violation = problem.assemble(mu);
    duration = problem.duration();
    out.gap = gap / duration;
    const double left = out.gap + out.violation / 3.0,
                 enough = options.gap * std::min(1.0, kLongS / duration);
    if (left < kEarly && (!looked || left < enough)) {
      const bool joined = problem.activate(rows, left < enough ? kLateRatio : kEarlyRatio);
      looked = true;
      if (joined) continue;
      if (left < enough) break;
    }
    if (!(options.from_both_ends ? problem.solve_step_from_both_ends() : problem.solve_step())) break;
    const auto lengths = problem.step_lengths(mu, kToBoundary);
    problem.move(lengths);
    const double shorter = std::min(lengths.primal, lengths.dual);
    centring = std::clamp((1.0 - shorter) * (1.0 - shorter), kLeastCentring, kMostCentring);
  }
  out.groups = problem.groups();
  problem.result(out);
  if (gradient) problem.time_gradient(rows, top, *gradient);
}

}  // namespace firn::motion
