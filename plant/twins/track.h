// Track computes a motion through knots of position, velocity and time in the plane: cubic between two knots,
// as a controller's PVT mode moves.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plant/record/archive.h"

namespace firn::plant {

struct TrackKnot {
  double t_s = 0.0, x_mm = 0.0, y_mm = 0.0, vx_mm_s = 0.0, vy_mm_s = 0.0;
};

class Track {
 public:
  Track() = default;
  static constexpr int kParts = 8;  ///< of the way between two knots, each by Gauss's rule with 3 points
  /// @pre at least two knots, times ascend from 0
  /// @param parts_per_knot fewer than kParts are enough where knots are dense
  Track(std::vector<TrackKnot> knots, std::int64_t start_us, int parts_per_knot = kParts);

  std::int64_t start_us() const { return start_us_; }
  std::int64_t end_us() const;
  std::array<double, 2> position(std::int64_t t_us) const { return at(seconds(t_us)).p; }
  std::array<double, 2> velocity(std::int64_t t_us) const { return at(seconds(t_us)).v; }
  double length_mm() const { return way_mm_.empty() ? 0.0 : way_mm_.back(); }
  double travelled_mm(std::int64_t t_us) const;
  /// Returns the first time [s since the start] at which the way is s_mm, 0 <= s_mm <= length.
  double time_of_s(double s_mm) const;
  const std::vector<TrackKnot>& knots() const { return knots_; }
  void io(Archive& a);

 private:
  struct State {
    std::array<double, 2> p{}, v{};
  };
  double seconds(std::int64_t t_us) const { return double(t_us - start_us_) * 1e-6; }
  State at(double t_s) const;
  State within(std::size_t knot, double t_s) const;
  double way_over(std::size_t knot, double from_s, double to_s) const;
  double part_begin_s(std::size_t part) const;
  void measure();

  std::vector<TrackKnot> knots_;
  std::int64_t start_us_ = 0;
  std::int32_t parts_ = kParts;
  std::vector<double> way_mm_;  ///< at the beginning of each part, and at the end
};

}  // namespace firn::plant
