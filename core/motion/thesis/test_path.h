// Computes the test path of [Barnett 2012, Fig. 4-2]: a 92 mm box with rounds of 20, 10 and 5 mm and one
// sharp corner, from (46, 0) counter-clockwise.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/exact/exact_math.h"
#include "core/path/path.h"

namespace firn::motion::thesis {

/// The exact point (lines and arcs) at distance s from the start, up to the sharp corner at (0, 0) and on to
/// (46, 0).
inline Point2 fig_4_2_at(double s) {
  struct Piece {
    double length, radius, heading_rad;  // heading at its start
    Point2 from;
  };
  const double quarter = std::numbers::pi / 2;
  static const std::vector<Piece> pieces{{26, 0, 0, {46, 0}},
                                         {20 * quarter, 20, 0, {72, 0}},
                                         {62, 0, quarter, {92, 20}},
                                         {10 * quarter, 10, quarter, {92, 82}},
                                         {77, 0, 2 * quarter, {82, 92}},
                                         {5 * quarter, 5, 2 * quarter, {5, 92}},
                                         {87, 0, 3 * quarter, {0, 87}},
                                         {46, 0, 0, {0, 0}}};
  std::size_t k = 0;
  while (k + 1 < pieces.size() && s > pieces[k].length) s -= pieces[k++].length;
  const Piece& p = pieces[k];
  if (p.radius == 0)
    return {p.from.x_mm + s * exact::cos(p.heading_rad), p.from.y_mm + s * exact::sin(p.heading_rad)};
  const double turn = s / p.radius;
  return {p.from.x_mm + p.radius * (exact::sin(p.heading_rad + turn) - exact::sin(p.heading_rad)),
          p.from.y_mm - p.radius * (exact::cos(p.heading_rad + turn) - exact::cos(p.heading_rad))};
}

inline constexpr double kFig42Corner = 306.97787143782136;  ///< distance of the sharp corner
inline constexpr double kFig42Length = kFig42Corner + 46.0;

/// Points at L / round(L / spacing) on each of the two pieces.
inline std::vector<Point2> fig_4_2(double spacing_mm = 0.4) {
  std::vector<Point2> path{fig_4_2_at(0)};
  for (const auto& [from, to] : {std::pair{0.0, kFig42Corner}, {kFig42Corner, kFig42Length}}) {
    const int n = int(std::lround((to - from) / spacing_mm));
    for (int i = 1; i <= n; ++i) path.push_back(fig_4_2_at(from + (to - from) * i / n));
  }
  return path;
}

inline constexpr Point2 kWellPlaced{354.0, -46.0};               ///< Fig. 4-3
inline constexpr Point2 kPoorlyPlaced{505.899114633174, -46.0};  ///< furthest point 599 mm from joint 1

}  // namespace firn::motion::thesis
