#include "files/path/bezier_pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace firn {
namespace {

using Control = std::vector<WeightedPoint>;

constexpr int kMaxHalvings = 10;

/// b + share (a - b).
Point2 between(Point2 a, Point2 b, double share) {
  return {b.x_mm + share * (a.x_mm - b.x_mm), b.y_mm + share * (a.y_mm - b.y_mm)};
}

/// The cubic with the curve's ends and its derivatives there.
CubicBezier hermite(std::span<const WeightedPoint> c) {
  const std::size_t n = c.size() - 1;
  const Point2 start = c[0].point(), end = c[n].point();
  const double third = double(n) / 3.0;
  return {start, between(c[1].point(), start, third * c[1].w / c[0].w),
          between(c[n - 1].point(), end, third * c[n - 1].w / c[n].w), end};
}

double binomial(std::size_t n, std::size_t k) {
  double product = 1.0;
  for (std::size_t i = 1; i <= k; ++i) product = product * double(n - k + i) / double(i);
  return product;
}

/// Bound of the distance of a cubic from the curve.
double error_mm(std::span<const WeightedPoint> c, const CubicBezier& cubic) {
  const std::size_t n = c.size() - 1;
  double most = 0.0, min_weight = c[0].w;
  for (const WeightedPoint& p : c) min_weight = std::min(min_weight, p.w);
  for (std::size_t k = 0; k <= n + 3; ++k) {
    double x = 0.0, y = 0.0;
    for (std::size_t i = k > n ? k - n : 0; i <= std::min<std::size_t>(3, k); ++i) {
      const WeightedPoint& p = c[k - i];
      const double share = binomial(3, i) * binomial(n, k - i) / binomial(n + 3, k);
      x += share * (p.x - p.w * cubic[i].x_mm);
      y += share * (p.y - p.w * cubic[i].y_mm);
    }
    most = std::max(most, std::sqrt(x * x + y * y));
  }
  return most / min_weight;
}

/// De Casteljau at the middle: the left half, and the right one in `c`.
Control halve(Control& c) {
  Control left;
  for (std::size_t size = c.size(); size > 0; --size) {
    left.push_back(c[0]);
    for (std::size_t i = 0; i + 1 < size; ++i)
      c[i] = {0.5 * (c[i].x + c[i + 1].x), 0.5 * (c[i].y + c[i + 1].y), 0.5 * (c[i].w + c[i + 1].w)};
  }
  return left;
}

bool follow(Control c, int halvings, std::vector<CubicBezier>& pieces) {
  const CubicBezier cubic = hermite(c);
  if (error_mm(c, cubic) <= kCubicError_mm) {
    pieces.push_back(cubic);
    return true;
  }
  if (halvings == 0) return false;
  Control left = halve(c);
  return follow(std::move(left), halvings - 1, pieces) && follow(std::move(c), halvings - 1, pieces);
}

}  // namespace

bool cubic_pieces(std::span<const WeightedPoint> c, std::vector<CubicBezier>& pieces) {
  const bool rational =
      std::any_of(c.begin(), c.end(), [&](const WeightedPoint& p) { return p.w != c[0].w; });
  if (!rational && c.size() == 4) {
    pieces.push_back({c[0].point(), c[1].point(), c[2].point(), c[3].point()});
    return true;
  }
  if (!rational && c.size() == 3) {  // of the second degree
    pieces.push_back(hermite(c));
    return true;
  }
  const std::size_t before = pieces.size();
  if (follow({c.begin(), c.end()}, kMaxHalvings, pieces)) return true;
  pieces.resize(before);
  return false;
}

int ellipse_pieces(double radius_mm) {
  constexpr int kFewest = 32, kMax = 128;
  const auto off = [&](int pieces) {
    const double quarter = 0.5 * std::numbers::pi / pieces, sine = std::sin(quarter),
                 cosine = std::cos(quarter);
    return radius_mm * 2.0 / 27.0 * sine * sine * sine * sine * sine * sine / (cosine * cosine);
  };
  int pieces = kFewest;
  while (pieces < kMax && off(pieces) > kCubicError_mm) pieces += 4;
  return pieces;
}

}  // namespace firn
