#include "plant/ice/arm.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn::plant {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

}  // namespace

TrueArm::TrueArm(const IceArmParams& params)
    : params_(params),
      step_s_(kStep_s * (1.0 + params.clock_ppm * 1e-6)),
      servo_(params.servo_hz, params.servo_damping, false, kStep_s),
      flex_(params.cantilever_hz, params.cantilever_damping, true, kStep_s) {
  place({0.0, 90.0 * kRad, params.high[2], -90.0 * kRad});
}

void TrueArm::place(const Joints& q) {
  reference_ = q;
  for (std::size_t n = 0; n < 4; ++n) joint_[n] = servo_.at_rest(q[n]);
  const double beta = q[0] + q[1];
  flange_ = {params_.link_1_mm * std::cos(q[0]) + params_.link_2_mm * std::cos(beta),
             params_.link_1_mm * std::sin(q[0]) + params_.link_2_mm * std::sin(beta)};
  for (std::size_t n = 0; n < 2; ++n) tip_[n] = flex_.at_rest(flange_[n]);
  points_.clear();
  still_ = true;
  show();
  pose_[0] = pose_[1];
}

void TrueArm::follow(std::vector<Joints> points, double tick_s, double start_s) {
  const double before_s = newest_s();
  points_ = std::move(points);
  tick_s_ = tick_s;
  path_s_ = 0.0;
  rate_ = 1.0;
  brake_per_s_ = 0.0;
  settle_s_ = kSettle_s;
  // The raster of samples begins anew at the start; it is within the step in which the one before ended.
  start_s_ = still_ ? start_s : std::max(start_s, before_s);
  sample_ = 0;
  still_ = false;
  pose_[0] = pose_[1];
}

void TrueArm::brake(double within_s) {
  if (!points_.empty() && brake_per_s_ == 0.0) brake_per_s_ = 1.0 / within_s;
}

double TrueArm::left_s() const {
  if (points_.empty()) return 0.0;
  if (brake_per_s_ > 0.0) return rate_ / brake_per_s_;
  return std::max(0.0, double(points_.size() - 1) * tick_s_ - path_s_);
}

double TrueArm::end_s() const { return newest_s() + left_s() * (1.0 + params_.clock_ppm * 1e-6); }

Joints TrueArm::reference_at(double path_s) const {
  const double u = std::clamp(path_s / tick_s_, 0.0, double(points_.size() - 1));
  const auto n = std::min(std::size_t(u), points_.size() - 1), m = std::min(n + 1, points_.size() - 1);
  const double f = u - double(n);
  Joints out;
  for (std::size_t k = 0; k < 4; ++k) out[k] = points_[n][k] + f * (points_[m][k] - points_[n][k]);
  return out;
}

void TrueArm::take_sample() {
  ++sample_;
  const Joints before = reference_;
  if (!points_.empty()) {
    const double slower = std::max(0.0, rate_ - brake_per_s_ * kStep_s);
    path_s_ += 0.5 * (rate_ + slower) * kStep_s;
    rate_ = slower;
    reference_ = reference_at(path_s_);
    if (rate_ <= 0.0 || path_s_ >= double(points_.size() - 1) * tick_s_ - 1e-9) points_.clear();
  } else {
    settle_s_ -= kStep_s;
  }
  for (std::size_t n = 0; n < 4; ++n) joint_[n] = servo_.next(joint_[n], before[n], reference_[n]);
  const double alpha = joint_[0].x, beta = joint_[0].x + joint_[1].x;
  const std::array<double, 2> flange{
      params_.link_1_mm * std::cos(alpha) + params_.link_2_mm * std::cos(beta),
      params_.link_1_mm * std::sin(alpha) + params_.link_2_mm * std::sin(beta)};
  for (std::size_t n = 0; n < 2; ++n) tip_[n] = flex_.next(tip_[n], flange_[n], flange[n]);
  flange_ = flange;
  pose_[0] = pose_[1];
  show();
  if (settle_s_ <= 0.0) still_ = true;
}

void TrueArm::show() {
  const double yaw = joint_[0].x + joint_[1].x + joint_[3].x;
  ArmPose& p = pose_[1];
  p.x_mm = tip_[0].x - params_.origin_mm[0];
  p.y_mm = tip_[1].x - params_.origin_mm[1];
  p.z_mm = joint_[2].x - params_.origin_mm[2];
  p.cos_yaw = std::cos(yaw);
  p.sin_yaw = std::sin(yaw);
  p.vx_mm_s = still_ ? 0.0 : flex_.velocity(tip_[0], flange_[0]);
  p.vy_mm_s = still_ ? 0.0 : flex_.velocity(tip_[1], flange_[1]);
}

void TrueArm::run_until(double t_s, const Seen& seen) {
  while (!still_ && newest_s() + step_s_ <= t_s) {
    take_sample();
    if (seen) seen(newest_s(), pose_[1]);
  }
}

ArmPose TrueArm::at(double t_s, const Seen& seen) {
  if (still_) return pose_[1];
  if (t_s <= start_s_) return pose_[0];
  while (newest_s() < t_s && !still_) {
    take_sample();
    if (seen) seen(newest_s(), pose_[1]);
  }
  const double f = std::clamp(1.0 - (newest_s() - t_s) / step_s_, 0.0, 1.0);
  ArmPose p = pose_[1];
  const auto mix = [f](double a, double b) { return a + f * (b - a); };
  p.x_mm = mix(pose_[0].x_mm, p.x_mm);
  p.y_mm = mix(pose_[0].y_mm, p.y_mm);
  p.z_mm = mix(pose_[0].z_mm, p.z_mm);
  p.cos_yaw = mix(pose_[0].cos_yaw, p.cos_yaw);
  p.sin_yaw = mix(pose_[0].sin_yaw, p.sin_yaw);
  p.vx_mm_s = mix(pose_[0].vx_mm_s, p.vx_mm_s);
  p.vy_mm_s = mix(pose_[0].vy_mm_s, p.vy_mm_s);
  return p;
}

Joints TrueArm::encoders() const {
  Joints out;
  for (std::size_t n = 0; n < 4; ++n) {
    const double count = n == 2 ? params_.encoder[n] : params_.encoder[n] * kRad;
    out[n] = std::round(joint_[n].x / count) * count;
  }
  return out;
}

void TrueArm::io(Archive& a) {
  a.all(joint_, tip_, reference_, flange_, pose_, points_, tick_s_, path_s_, rate_, brake_per_s_, start_s_,
        settle_s_, sample_, still_);
}

}  // namespace firn::plant
