// Move computes straight moves with a trapezoidal speed in closed form: position at a time, and time at a
// position.
#pragma once

#include <array>
#include <cstdint>

#include "plant/record/archive.h"

namespace firn::plant {

using Vec3 = std::array<double, 3>;

/// Holds one straight move. Inside: s in mm along it, t in s since its start.
class Move {
 public:
  Move() = default;
  /// From rest to rest. @pre speed, acceleration > 0
  static Move trapezoid(const Vec3& from, const Vec3& to, double speed_mm_s, double accel_mm_s2,
                        std::int64_t t0_us);
  /// Braking from `speed_mm_s` along `direction` (unit length).
  static Move stop(const Vec3& from, const Vec3& direction, double speed_mm_s, double decel_mm_s2,
                   std::int64_t t0_us);

  std::int64_t start_us() const { return t0_us_; }
  std::int64_t end_us() const;  ///< first whole microsecond at rest
  double length_mm() const { return length_; }
  const Vec3& from() const { return from_; }
  const Vec3& direction() const { return direction_; }

  double travelled_mm(std::int64_t t_us) const;  ///< s
  double speed_mm_s(std::int64_t t_us) const;
  Vec3 position(std::int64_t t_us) const;
  /// Returns the time [s since the start] at which s_mm is reached, 0 <= s_mm <= length.
  double time_of_s(double s_mm) const;
  double speed_at_s(double s_mm) const;

  void io(Archive& a);

 private:
  struct Phase {
    double t_s = 0.0, s_mm = 0.0, v_mm_s = 0.0, a_mm_s2 = 0.0;  ///< values at its beginning
  };
  const Phase& phase_at_s(double s_mm) const;
  const Phase& phase_at_t(double t_s) const;

  std::int64_t t0_us_ = 0;
  Vec3 from_{}, direction_{};
  double length_ = 0.0, duration_s_ = 0.0;
  int phases_ = 0;
  std::array<Phase, 3> phase_{};
};

}  // namespace firn::plant
