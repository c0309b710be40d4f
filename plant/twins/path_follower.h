// PathFollower computes the motion of X and Y along a program's path: the plan, the axes behind it, and what
// their encoders report.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "plant/config/world_config.h"
#include "plant/twins/servo.h"
#include "plant/twins/track.h"

namespace firn::plant {

class PathFollower {
 public:
  PathFollower() = default;
  /// @param start where the axes stand [mm]; the first knot, but for axes that have not settled
  PathFollower(std::vector<TrackKnot> knots, std::int64_t start_us, const std::array<double, 2>& start_mm,
               const StageParams& params);

  std::int64_t start_us() const { return plan_.start_us(); }
  std::int64_t end_us() const { return truth_.end_us(); }
  std::array<double, 2> position(std::int64_t t_us) const { return truth_.position(t_us); }
  std::array<double, 2> velocity(std::int64_t t_us) const { return truth_.velocity(t_us); }
  std::array<double, 2> feedback(std::int64_t t_us) const { return counted().position(t_us); }
  /// The way of X and Y as their encoders count it.
  const Track& counted() const { return encoder_ ? *encoder_ : truth_; }

  /// X follows with a tenth of its bandwidth, or as before, from now on.
  void drag(bool on, std::int64_t now_us, const StageParams& params);
  /// X's encoder reports its place of now from now on. X goes on by what is fed forward.
  void stick_encoder(std::int64_t now_us, double x_mm, const StageParams& params);
  /// First moment at which an axis is farther from the plan, by its encoder, than the controller permits.
  std::int64_t fault_us() const { return fault_us_; }
  int fault_axis() const { return fault_axis_; }
  void io(Archive& a);

 private:
  void follow(std::int64_t from_us, const std::array<double, 2>& offset_mm, const StageParams& params);

  Track plan_, truth_;
  std::optional<Track> encoder_;
  bool drags_ = false;
  std::int64_t fault_us_ = INT64_MAX;
  std::int32_t fault_axis_ = 0;
};

}  // namespace firn::plant
