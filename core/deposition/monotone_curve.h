// MonotoneCurve computes a strictly increasing function through measured points: piecewise cubic Hermite
// interpolation whose slopes keep it monotone [Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980); slopes by
// the weighted harmonic mean of Fritsch and Butland (1984)]. Between two points it never leaves their range,
// so a calibration table cannot overshoot.
#pragma once

#include <span>
#include <vector>

namespace firn::deposition {

class MonotoneCurve {
 public:
  struct Point {
    double x = 0.0;
    double y = 0.0;
  };
  /// @throws std::invalid_argument naming the row: at least two points, all finite, x and y both strictly
  /// ascending.
  explicit MonotoneCurve(std::vector<Point> points);

  double at(double x) const;       ///< clamped to the first and last point
  double inverse(double y) const;  ///< the x with at(x) = y to 2^-52 of the interval; clamped in the same way
  double slope_at_start() const { return slopes_.front(); }
  std::span<const Point> points() const { return points_; }

 private:
  double inside(std::size_t row, double x) const;

  std::vector<Point> points_;
  std::vector<double> slopes_;
};

}  // namespace firn::deposition
