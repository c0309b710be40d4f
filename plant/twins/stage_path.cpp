// StageDevice: the program that follows a path of X and Y and records its position.
#include <algorithm>
#include <cmath>

#include "plant/twins/stage.h"

namespace firn::plant {
namespace {

constexpr std::uint32_t kPathFault = 1u << 0;
constexpr double kUnsettled_mm = 0.02;  // of an axis at the end of a move, before it is in position

}  // namespace

// A knot out of range, or one that the motion would jump to, is refused: nothing has moved then.
StageDevice::Answer StageDevice::follow_path(std::int64_t now_us) {
  constexpr double kJump_mm = 0.005;
  constexpr double kRest_mm_s = 0.01;
  const double count = iglobals_[kKnotCountIglobal];
  if (moving() || !(count >= 2.0 && 5.0 * count <= kDglobals)) return Answer::kNak;
  std::vector<TrackKnot> knots;
  for (std::size_t k = 0; k < std::size_t(count); ++k) {
    const double* d = dglobals_.data() + 5 * k;
    const TrackKnot knot{d[0], d[1], d[2], d[3], d[4]};
    const double at[2] = {knot.x_mm, knot.y_mm};
    if (k == 0 ? knot.t_s != 0.0 : !(knot.t_s > knots.back().t_s)) return Answer::kNak;
    if (std::hypot(knot.vx_mm_s, knot.vy_mm_s) > params_.max_speed_mm_s) return Answer::kNak;
    for (std::size_t a = 0; a < 2; ++a)
      if (!(at[a] >= params_.low_limit_mm[a] && at[a] <= params_.high_limit_mm[a])) return Answer::kNak;
    knots.push_back(knot);
  }
  for (const TrackKnot& end : {knots.front(), knots.back()})
    if (std::hypot(end.vx_mm_s, end.vy_mm_s) > kRest_mm_s) return Answer::kNak;
  if (std::hypot(knots[0].x_mm - at_mm_[0], knots[0].y_mm - at_mm_[1]) > kJump_mm) return Answer::kNak;
  for (int a = 0; a < 2; ++a)
    if (faults_[a] != 0 || !enabled_[a]) return Answer::kFault;
  current_ = {{NAN, NAN, NAN}, 0.0, 3u, 0u};
  if (stuck_) {
    raise(0, kPathFault, now_us);
    return Answer::kOk;
  }
  sample_first_ = std::uint32_t(5 * knots.size());
  sample_period_us_ = iglobals_[kSamplePeriodIglobal] * 1e3;
  iglobals_[kSampleCountIglobal] = 0.0;
  const double unsettled_mm =
      now_us < in_position_us_ ? kUnsettled_mm * double(in_position_us_ - now_us) / double(params_.settle_us)
                               : 0.0;
  track_.emplace(std::move(knots), now_us, std::array{at_mm_[0] + unsettled_mm, at_mm_[1]}, params_);
  if (drags_) track_->drag(true, now_us, params_);
  if (frozen_x_mm_) track_->stick_encoder(now_us, *frozen_x_mm_, params_);
  wires_.note(now_us, Port::kStage, DeviceEvent::kStageMoving, 0);
  find_pulse();
  return Answer::kOk;
}

// The way as the encoders counted it stays with the pulse output, the samples with the program.
void StageDevice::leave_track(std::int64_t now_us) {
  record_samples(now_us);
  pso_[0].travel_mm += track_->counted().travelled_mm(now_us);
  at_mm_ = position_mm(now_us);
  track_.reset();
}

void StageDevice::end_track(std::int64_t now_us) { leave_track(std::min(now_us, track_->end_us())); }

Vec3 StageDevice::feedback_mm(std::int64_t now_us) const {
  Vec3 at = position_mm(now_us);
  if (track_) {
    const auto p = track_->feedback(now_us);
    at[0] = p[0];
    at[1] = p[1];
  }
  if (frozen_x_mm_) at[0] = *frozen_x_mm_;
  return at;
}

// Whole counts. They end where the numbers do, and with the motion.
void StageDevice::record_samples(std::int64_t now_us) {
  if (!track_ || !(sample_period_us_ > 0.0)) return;
  auto count = std::uint32_t(iglobals_[kSampleCountIglobal]);
  for (; sample_first_ + 2 * count + 1 < dglobals_.size(); ++count) {
    const std::int64_t at_us = track_->start_us() + std::llround(double(count) * sample_period_us_);
    if (at_us > now_us) break;
    const auto at = track_->feedback(at_us);
    for (std::size_t a = 0; a < 2; ++a)
      dglobals_[sample_first_ + 2 * count + a] =
          double(encoder_counts(int(a), at[a])) / params_.counts_per_mm;
  }
  iglobals_[kSampleCountIglobal] = double(count);
}

void StageDevice::drag(bool on, std::int64_t now_us) {
  drags_ = on;
  if (!track_) return;
  record_samples(now_us);
  track_->drag(on, now_us, params_);
  find_pulse();
}

void StageDevice::stick_encoder(bool on, std::int64_t now_us) {
  if (track_) record_samples(now_us);
  frozen_x_mm_ = on ? std::optional<double>(feedback_mm(now_us)[0]) : std::nullopt;
  if (!track_ || !on) return;
  track_->stick_encoder(now_us, *frozen_x_mm_, params_);
  find_pulse();
}

}  // namespace firn::plant
