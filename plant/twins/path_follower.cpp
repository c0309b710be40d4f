#include "plant/twins/path_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::plant {
namespace {

constexpr double kDragShare = 0.1;  // of the bandwidth
constexpr int kDensePerKnot = 1;    // parts of a dense track between two knots
constexpr double kFaultStep_s = 0.001;

}  // namespace

PathFollower::PathFollower(std::vector<TrackKnot> knots, std::int64_t start_us,
                           const std::array<double, 2>& start_mm, const StageParams& params)
    : plan_(std::move(knots), start_us), truth_(plan_) {
  const auto at = plan_.position(start_us);
  if (params.servo_hz > 0.0) follow(start_us, {start_mm[0] - at[0], start_mm[1] - at[1]}, params);
}

void PathFollower::follow(std::int64_t from_us, const std::array<double, 2>& offset_mm,
                          const StageParams& params) {
  const ServoAxis even{params.servo_hz, params.servo_damping, params.servo_feed_forward};
  std::array<ServoAxis, 2> axes{even, even};
  if (drags_) axes[0].hz *= kDragShare;
  const double from_s = double(from_us - plan_.start_us()) * 1e-6;
  const auto p = truth_.position(from_us), v = truth_.velocity(from_us);
  const Following f = follow_plan(plan_, axes, {from_s, p[0] + offset_mm[0], p[1] + offset_mm[1], v[0], v[1]},
                                  params.position_error_mm);
  std::vector<TrackKnot> whole;
  if (from_us > plan_.start_us())
    for (const TrackKnot& k : truth_.knots())
      if (k.t_s < from_s - 1e-9) whole.push_back(k);
  whole.insert(whole.end(), f.knots.begin(), f.knots.end());
  truth_ = Track(std::move(whole), plan_.start_us(), kDensePerKnot);
  fault_us_ = INT64_MAX;
  for (std::size_t a = 0; a < 2; ++a)
    if (f.too_far_s[a] < 1e9) {
      const std::int64_t at_us = plan_.start_us() + std::llround(f.too_far_s[a] * 1e6);
      if (at_us < fault_us_) fault_axis_ = std::int32_t(a);
      fault_us_ = std::min(fault_us_, at_us);
    }
}

void PathFollower::drag(bool on, std::int64_t now_us, const StageParams& params) {
  if (std::exchange(drags_, on) != on && params.servo_hz > 0.0) follow(now_us, {}, params);
}

void PathFollower::stick_encoder(std::int64_t now_us, double x_mm, const StageParams& params) {
  const double from_s = double(now_us - plan_.start_us()) * 1e-6;
  const auto here = truth_.position(now_us), speed = truth_.velocity(now_us);
  std::vector<TrackKnot> knots;
  for (const TrackKnot& k : truth_.knots())
    if (k.t_s < from_s - 1e-9) knots.push_back(k);
  knots.push_back({from_s, x_mm, here[1], 0.0, speed[1]});
  for (TrackKnot k : truth_.knots())
    if (k.t_s > from_s + 1e-9) {
      k.x_mm = x_mm;
      k.vx_mm_s = 0.0;
      knots.push_back(k);
    }
  encoder_.emplace(std::move(knots), plan_.start_us(), kDensePerKnot);
  const double end_s = double(plan_.end_us() - plan_.start_us()) * 1e-6;
  for (double t = from_s; t <= end_s; t += kFaultStep_s) {
    const std::int64_t at_us = plan_.start_us() + std::llround(t * 1e6);
    if (std::abs(plan_.position(at_us)[0] - x_mm) <= params.position_error_mm) continue;
    if (at_us < fault_us_) fault_axis_ = 0;
    fault_us_ = std::min(fault_us_, at_us);
    return;
  }
}

void PathFollower::io(Archive& a) {
  bool stuck = encoder_.has_value();
  Track e = stuck ? *encoder_ : Track{};
  a.all(plan_, truth_, stuck, e, drags_, fault_us_, fault_axis_);
  if (a.loading()) encoder_ = stuck ? std::optional<Track>(std::move(e)) : std::nullopt;
}

}  // namespace firn::plant
