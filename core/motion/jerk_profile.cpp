#include "core/motion/jerk_profile.h"

#include <algorithm>
#include <cmath>

#include "core/motion/profile_problem.h"

namespace firn::motion {

void solve_profile(const Curve& curve, const MotionRows& rows, const RowGroups& groups,
                   const std::vector<double>& top, const std::vector<double>& bound,
                   const ProfileOptions& options, ProfileWork& work, Profile& out) {
  ProfileProblem problem(curve, rows, groups, top, bound, work);
  double centring = 0.3;
  for (out.iterations = 0; out.iterations < options.most_iterations; ++out.iterations) {
    const double gap = problem.complementarity(), mu = centring * gap / double(problem.terms());
    out.violation = problem.assemble(mu);
    out.gap = gap / problem.duration();
    if (out.gap + out.violation / 3.0 < options.gap || !problem.solve_step()) break;
    const auto lengths = problem.step_lengths(mu, 0.95);
    problem.move(lengths);
    const double shorter = std::min(lengths.primal, lengths.dual);
    centring = std::clamp((1.0 - shorter) * (1.0 - shorter), 0.05, 0.8);
  }
  problem.result(out);
}

}  // namespace firn::motion
