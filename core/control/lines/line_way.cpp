// The way of a plan as a stage follows it.
#include <algorithm>
#include <cmath>

#include "core/control/lines/line_controller.h"

namespace firn::control {
namespace {

constexpr double kShortest_s = 1e-6;  // a shorter piece ends within a nanometre of where it began
constexpr double kMin_mm = 1e-3;      // between two switches

struct Part {
  double t_s = 0.0, duration_s = 0.0;
  Point2 v, a;
};

// Way of a part up to t, by Gauss's rule with 3 points on eight pieces.
double way_within(const Part& p, double t_s) {
  constexpr double kNode = 0.7745966692414834;  // sqrt(3/5)
  constexpr int kPieces = 8;
  const auto speed = [&](double t) {
    const double vx = p.v.x_mm + p.a.x_mm * t, vy = p.v.y_mm + p.a.y_mm * t;
    return std::sqrt(vx * vx + vy * vy);
  };
  double way = 0.0;
  const double half = 0.5 * t_s / kPieces;
  for (int n = 0; n < kPieces; ++n) {
    const double middle = (2 * n + 1) * half;
    way += half *
           (5.0 * speed(middle - half * kNode) + 8.0 * speed(middle) + 5.0 * speed(middle + half * kNode)) /
           9.0;
  }
  return way;
}

}  // namespace

LineWay way_of(const motion::AerosolPlan& plan, double open_delay_s, double close_delay_s) {
  LineWay way;
  std::vector<Part> parts;
  const auto knot = [&](double t, const Point2& p, const Point2& v) {
    way.t_s.push_back(t);
    way.x_mm.push_back(p.x_mm);
    way.y_mm.push_back(p.y_mm);
    way.vx_mm_s.push_back(v.x_mm);
    way.vy_mm_s.push_back(v.y_mm);
  };
  for (const motion::Piece& piece : plan.pieces) {
    if (piece.duration_s < kShortest_s) continue;
    knot(piece.t_s, piece.p_mm, piece.v_mm_s);
    parts.push_back({piece.t_s, piece.duration_s, piece.v_mm_s, piece.a_mm_s2});
  }
  if (parts.empty()) return {};
  way.t_s.front() = 0.0;
  const motion::PlaneState end = motion::state_at(plan, plan.duration_s());
  knot(plan.duration_s(), end.p_mm, {0.0, 0.0});

  std::vector<double> begun{0.0};
  for (const Part& p : parts) begun.push_back(begun.back() + way_within(p, p.duration_s));
  const auto way_at = [&](double t) {
    std::size_t k = 0;
    while (k + 1 < parts.size() && parts[k + 1].t_s <= t) ++k;
    return begun[k] + way_within(parts[k], std::clamp(t - parts[k].t_s, 0.0, parts[k].duration_s));
  };
  for (const ShutterSpan& span : plan.open) {
    const double open = std::max(kMin_mm, way_at(std::max(0.0, span.open_s - open_delay_s)));
    const double close = std::max(open + kMin_mm, way_at(std::max(0.0, span.close_s - close_delay_s)));
    if (!way.switch_mm.empty() && open < way.switch_mm.back() + kMin_mm) {
      way.switch_mm.back() = std::min(close, begun.back());  // too near to close between
      continue;
    }
    way.switch_mm.push_back(open);
    way.switch_mm.push_back(close);
  }
  return way;
}

}  // namespace firn::control
