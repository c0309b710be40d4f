#include "core/motion/aerosol/builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/motion/aerosol/check.h"
#include "core/motion/aerosol/lspb.h"
#include "core/motion/aerosol/measure.h"

namespace firn::motion {
namespace {

constexpr double kMinLine_s = 1e-9;

bool is_open(PieceKind kind) { return kind == PieceKind::kPrint || kind == PieceKind::kRound; }

double acceleration(const AxisProfile& p, double t) {
  return t < p.tb0_s ? p.a0_mm_s2 : t > p.tb1_s ? p.a1_mm_s2 : 0.0;
}

// Least and largest value of one axis over a piece.
std::pair<double, double> reach(double p, double v, double a, double duration) {
  const double end = p + duration * (v + 0.5 * a * duration);
  double low = std::min(p, end), high = std::max(p, end);
  if (const double turn = a == 0.0 ? -1.0 : -v / a; turn > 0.0 && turn < duration) {
    const double there = p + 0.5 * v * turn;
    low = std::min(low, there);
    high = std::max(high, there);
  }
  return {low, high};
}

}  // namespace

void PlanBuilder::begin(const Point2& start) { p_ = start; }

void PlanBuilder::refuse(std::int32_t segment, std::string reason) {
  if (!plan_.refused.empty() && plan_.refused.back().segment == segment) return;  // one reason is enough
  plan_.refused.push_back({segment, std::move(reason)});
}

void PlanBuilder::append(const Piece& piece) {
  const double sign = machine_.substrate_moves ? -1.0 : 1.0;
  const auto outside = [&](const char* axis, double origin, double p, double v, double a, double low,
                           double high) {
    auto [least, most] = reach(sign * p, sign * v, sign * a, piece.duration_s);
    least += origin;
    most += origin;
    if (least >= low && most <= high) return false;
    refuse(piece.segment, std::string("the stage's ") + axis + " would go to " +
                              text(least < low ? least : most) + " mm, its range is " + text(low) + " to " +
                              text(high) + " mm");
    return true;
  };
  if (outside("x", machine_.stage_origin.x_mm, piece.p_mm.x_mm, piece.v_mm_s.x_mm, piece.a_mm_s2.x_mm,
              machine_.stage_low.x_mm, machine_.stage_high.x_mm) ||
      outside("y", machine_.stage_origin.y_mm, piece.p_mm.y_mm, piece.v_mm_s.y_mm, piece.a_mm_s2.y_mm,
              machine_.stage_low.y_mm, machine_.stage_high.y_mm))
    return;
  plan_.pieces.push_back(piece);
  AerosolReport& r = plan_.report;
  const double end = piece.t_s + piece.duration_s;
  if (!is_open(piece.kind)) return;
  if (!plan_.open.empty() && plan_.open.back().close_s >= piece.t_s - 1e-12)
    plan_.open.back().close_s = end;
  else
    plan_.open.push_back({piece.t_s, end});
  r.print_s += piece.duration_s;
}

// Between any two blend times of either axis both accelerations are constant.
void PlanBuilder::append(PieceKind kind, std::int32_t segment, const PlaneMove& move) {
  std::array<double, 6> at{0.0, move.x.tb0_s, move.x.tb1_s, move.y.tb0_s, move.y.tb1_s, move.x.t1_s};
  std::ranges::sort(at);
  for (std::size_t n = 0; n + 1 < at.size(); ++n) {
    const double from = at[n], duration = at[n + 1] - from, middle = from + 0.5 * duration;
    if (!(duration > 0.0)) continue;
    append({kind,
            segment,
            t_s_ + from,
            duration,
            {move.x.position(from), move.y.position(from)},
            {move.x.velocity(from), move.y.velocity(from)},
            {acceleration(move.x, middle), acceleration(move.y, middle)}});
  }
  t_s_ += move.x.t1_s;
  p_ = {move.x.ends.q1_mm, move.y.ends.q1_mm};
  v_ = {move.x.ends.v1_mm_s, move.y.ends.v1_mm_s};
}

void PlanBuilder::transit(PieceKind kind, std::int32_t segment, const Point2& to, const Point2& v1,
                          double at_least) {
  const AxisEnds x{p_.x_mm, to.x_mm, v_.x_mm, v1.x_mm}, y{p_.y_mm, to.y_mm, v_.y_mm, v1.y_mm};
  const PlaneMove move = synchronised_mtt(x, y, 0.0, machine_.axis, at_least);
  AerosolReport& r = plan_.report;
  r.lower_bound_s += std::max(mtt(x, 0.0, machine_.axis).t1_s, mtt(y, 0.0, machine_.axis).t1_s);
  r.transit_s += move.x.t1_s;
  ++(kind == PieceKind::kLoop ? r.loops : r.transits);
  if (kind == PieceKind::kLoop && move.x.t1_s > r.corner_s.value) r.corner_s = {move.x.t1_s, t_s_, segment};
  append(kind, segment, move);
}

void PlanBuilder::print(std::int32_t segment, const Point2& to, const Point2& v0, const Point2& v1,
                        double duration) {
  plan_.report.lower_bound_s += duration;
  if (duration < kMinLine_s) {  // two roundings use up the whole segment
    p_ = to;
    return;
  }
  const double alpha = machine_.axis.alpha_mm_s2;
  const AxisEnds ends[2]{{p_.x_mm, to.x_mm, v0.x_mm, v1.x_mm}, {p_.y_mm, to.y_mm, v0.y_mm, v1.y_mm}};
  std::optional<AxisProfile> found[2];
  for (int axis = 0; axis < 2; ++axis) {
    const std::string who = axis == 0 ? "axis x" : "axis y";
    found[axis] = lspb(ends[axis], 0.0, duration, alpha);
    if (!found[axis])
      refuse(segment, who + " cannot go from " + text(ends[axis].v0_mm_s) + " to " +
                          text(ends[axis].v1_mm_s) + " mm/s over " +
                          text(ends[axis].q1_mm - ends[axis].q0_mm) + " mm in " + text(duration) + " s at " +
                          text(alpha) + " mm/s^2");
    else if (std::abs(found[axis]->vc_mm_s) > machine_.axis.v_max_mm_s * (1.0 + 1e-9))
      refuse(segment, who + " needs " + text(std::abs(found[axis]->vc_mm_s)) +
                          " mm/s between its blends, the stage has " + text(machine_.axis.v_max_mm_s) +
                          " mm/s");
  }
  if (found[0] && found[1]) {
    append(PieceKind::kPrint, segment, {*found[0], *found[1]});
    return;
  }
  t_s_ += duration;  // the segments after it are still checked
  p_ = to;
  v_ = v1;
}

void PlanBuilder::round(std::int32_t segment, const Point2& corner, const Rounding& rounding) {
  for (Piece piece : rounding.pieces) {
    piece.segment = segment;
    piece.t_s += t_s_;
    piece.p_mm = {corner.x_mm + piece.p_mm.x_mm, corner.y_mm + piece.p_mm.y_mm};
    append(piece);
    const PlaneState end = state_of(piece, piece.duration_s);
    p_ = end.p_mm;
    v_ = end.v_mm_s;
  }
  t_s_ += rounding.duration_s;
  plan_.report.lower_bound_s += rounding.duration_s;
  ++plan_.report.rounded;
}

AerosolPlan PlanBuilder::finish() {
  if (!plan_.ok()) {
    AerosolPlan refused;
    refused.refused = std::move(plan_.refused);
    return refused;
  }
  plan_.report.total_s = t_s_;
  plan_.report.wasted_mm3 = machine_.flow_mm3_s * plan_.report.transit_s;
  return std::move(plan_);
}

}  // namespace firn::motion
