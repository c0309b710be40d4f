#include "core/deposition/monotone_curve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::deposition {

MonotoneCurve::MonotoneCurve(std::vector<Point> points) : points_(std::move(points)) {
  const std::size_t n = points_.size();
  if (n < 2)
    throw std::invalid_argument("a curve needs at least two points, this one has " + std::to_string(n));
  for (std::size_t i = 0; i < n; ++i) {
    const std::string row = "row " + std::to_string(i + 1) + " of the curve ";
    if (!std::isfinite(points_[i].x) || !std::isfinite(points_[i].y))
      throw std::invalid_argument(row + "is not finite");
    if (i > 0 && !(points_[i].x > points_[i - 1].x && points_[i].y > points_[i - 1].y))
      throw std::invalid_argument(row +
                                  "does not ascend: both columns must be above those of the row before");
  }
  std::vector<double> width(n - 1), secant(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    width[i] = points_[i + 1].x - points_[i].x;
    secant[i] = (points_[i + 1].y - points_[i].y) / width[i];
  }
  slopes_.resize(n);
  slopes_.front() = secant.front();  // as the chord: a curve from the origin starts out proportional
  slopes_.back() = secant.back();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = 2.0 * width[i] + width[i - 1], after = width[i] + 2.0 * width[i - 1];
    slopes_[i] = (before + after) / (before / secant[i - 1] + after / secant[i]);
  }
}

double MonotoneCurve::inside(std::size_t row, double x) const {
  const Point &a = points_[row], &b = points_[row + 1];
  const double width = b.x - a.x, t = (x - a.x) / width;
  const double secant = (b.y - a.y) / width, m0 = slopes_[row], m1 = slopes_[row + 1];
  const double y =
      a.y + width * t * (m0 + t * ((3.0 * secant - 2.0 * m0 - m1) + t * (m0 + m1 - 2.0 * secant)));
  return std::clamp(y, a.y, b.y);
}

double MonotoneCurve::at(double x) const {
  if (!(x > points_.front().x)) return points_.front().y;
  if (x >= points_.back().x) return points_.back().y;
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), x, [](double v, const Point& p) { return v < p.x; });
  return inside(std::size_t(after - points_.begin()) - 1, x);
}

double MonotoneCurve::inverse(double y) const {
  if (!(y > points_.front().y)) return points_.front().x;
  if (y >= points_.back().y) return points_.back().x;
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), y, [](double v, const Point& p) { return v < p.y; });
  const std::size_t row = std::size_t(after - points_.begin()) - 1;
  double low = points_[row].x, high = points_[row + 1].x;
  for (int n = 0; n < 53; ++n) {
    const double middle = 0.5 * (low + high);
    (inside(row, middle) < y ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace firn::deposition
