#include "core/motion/time_optimal/jerk_profile.h"

#include <algorithm>
#include <cmath>

#include "core/motion/time_optimal/constants.h"
#include "core/motion/time_optimal/profile_problem.h"

namespace firn::motion {
void solve_profile(const Curve& curve, const MotionRows& rows, RowGroups& groups, int active,
                   const std::vector<double>& top, const std::vector<double>& bound,
                   const ProfileOptions& options, ProfileWork& work, Profile& out, TimeGradient* gradient) {
  ProfileProblem problem(curve, rows, groups, active, top, bound, options.start, work);
  bool looked = false;
  double centring = kFirstCentring, duration = 0.0;
  out.violation = 0.0;
  for (out.iterations = 0; out.iterations < options.max_iterations; ++out.iterations) {
    const double gap = problem.complementarity();
    const double mu =
        1.0 / double(problem.terms()) *
        std::max(centring * gap, std::min(2.0 * gap, kGapPerViolation * out.violation * duration));
    out.violation = problem.assemble(mu);
    duration = problem.duration();
    out.gap = gap / duration;
    const double left = out.gap + out.violation / kViolationDivisor,
                 enough = options.gap * std::min(1.0, kLongMotion_s / duration);
    if (left < kFirstActivation && (!looked || left < enough)) {
      const bool joined = problem.activate(rows, kActivationRatio);
      looked = true;
      if (joined) continue;
      if (left < enough) break;
    }
    if (!problem.solve_step()) break;
    const auto lengths = problem.step_lengths(mu, kToBoundary);
    problem.move(lengths);
    const double shorter = std::min(lengths.primal, lengths.dual);
    centring = std::clamp((1.0 - shorter) * (1.0 - shorter), kMinCentring, kMaxCentring);
  }
  out.groups = problem.groups();
  problem.result(out);
  if (gradient) problem.time_gradient(rows, top, *gradient);
}

}  // namespace firn::motion
