#include "core/motion/thesis/thesis.h"

#include <algorithm>
#include <cmath>

#include "core/motion/kinematics/placement.h"
#include "core/motion/kinematics/require.h"
#include "core/motion/thesis/jcon.h"
#include "core/motion/thesis/savitzky_golay.h"
#include "core/motion/thesis/vcon.h"

namespace firn::motion {
namespace {

using thesis::Profile;

void check_options(const ThesisOptions& options) {
  require_positive(options.tick_s, "tick");
  require_positive(options.rest.step_s, "AREST step");
  require_positive(options.rest.acceleration_mm_s2, "AREST acceleration");
  require_positive(1.0 + options.margins.acceleration, "ACON acceleration margin");
  require_positive(1.0 + options.margins.jerk, "ACON jerk margin");
}

}  // namespace

namespace thesis {

Profile at_tick(const Profile& path, const Profile& timed, double tick_s) {
  const double duration = timed.duration_s();
  const std::size_t ticks = whole_ticks(duration, tick_s);
  const double time_scale = double(ticks) * tick_s / duration;
  Profile out;
  std::size_t k = 0;
  double before = 0.0;  // time at point k
  for (std::size_t n = 0; n <= ticks; ++n) {
    const double t = double(n) * tick_s;
    while (k + 1 < timed.dt_s.size() && before + timed.dt_s[k] * time_scale <= t)
      before += timed.dt_s[k++] * time_scale;
    const double f = std::clamp((t - before) / (timed.dt_s[k] * time_scale), 0.0, 1.0);
    const double s = n == ticks ? timed.s_mm.back() : timed.s_mm[k] + f * (timed.s_mm[k + 1] - timed.s_mm[k]);
    out.s_mm.push_back(s);
    append_at(path, s, out);
    if (n == 0) continue;
    out.dt_s.push_back(tick_s);
    out.speed_limit_mm_s.push_back(timed.speed_limit_mm_s[k]);
  }
  return out;
}

}  // namespace thesis

ThesisResult plan_thesis_steps(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                               const ThesisOptions& options) {
  check_limits(limits, arm.joints());
  check_options(options);
  const CleanPath path = clean(input);
  const ArmConfiguration configuration = configuration_for(path, input, arm);
  const int limited = limited_joints(limits, arm.joints());
  const bool turning = !path.yaw_rad.empty();
  // "global orientation" (4.1.3 to 4.1.5): its yaw is one coordinate and is shaped as one joint more
  MotionLimits shaped = limits;
  if (turning) shaped.joint.at(std::size_t(limited)) = limits.orientation;
  const auto joints = [&](const Profile& p) {
    auto all = joints_at(p.points, p.yaw_rad, limited, path, input, arm, configuration);
    if (turning) all.push_back(p.yaw_rad);
    return all;
  };
  ThesisResult result;
  Profile samples;
  for (Profile& profile : pathsplit(path, options.split)) {
    ThesisSteps steps;
    profile.joints = joints(profile);
    thesis::vcon(profile, shaped);
    steps.vcon = profile;
    thesis::acon(profile, shaped, options.margins);
    steps.acon = profile;
    thesis::jcon(profile, shaped, options.margins);
    steps.jcon = profile;
    whole_ticks(profile.duration_s(), options.rest.step_s);  // AREST makes at least that many points
    steps.arest = thesis::arest(profile, limits.position, options.rest);
    steps.arest.joints = joints(steps.arest);
    thesis::arest_joints(steps.arest, shaped, options.rest);
    Profile ticked = thesis::at_tick(profile, steps.arest, options.tick_s);
    ticked.joints = joints(ticked);
    if (ticked.size() >= 4) thesis::jcon(ticked, shaped, options.margins);
    steps.final = thesis::at_tick(profile, ticked, options.tick_s);
    const std::ptrdiff_t skip =
        samples.points.empty() ? 0 : 1;  // the end of one subpath is the start of the next
    samples.points.insert(samples.points.end(), steps.final.points.begin() + skip, steps.final.points.end());
    if (turning)
      samples.yaw_rad.insert(samples.yaw_rad.end(), steps.final.yaw_rad.begin() + skip,
                             steps.final.yaw_rad.end());
    result.steps.push_back(std::move(steps));
  }
  auto all = joints_at(samples.points, samples.yaw_rad, arm.joints(), path, input, arm, configuration);
  if (options.filter)
    for (auto& joint : all) joint = thesis::savitzky_golay_7(joint);
  result.trajectory = trajectory_of(all, arm, options.tick_s);
  return result;
}

Trajectory plan_thesis(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                       const ThesisOptions& options) {
  return plan_thesis_steps(input, arm, limits, options).trajectory;
}

}  // namespace firn::motion
