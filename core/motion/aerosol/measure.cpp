#include "core/motion/aerosol/measure.h"

#include <algorithm>
#include <cmath>

#include "core/path/polyline.h"

namespace firn::motion {
namespace {

constexpr int kSamples = 16, kSteps = 60;

void take(Extreme& extreme, double value, double t, std::int32_t segment) {
  if (value > extreme.value) extreme = {value, t, segment};
}

double speed(const Piece& p, double dt) {
  return distance({}, {p.v_mm_s.x_mm + p.a_mm_s2.x_mm * dt, p.v_mm_s.y_mm + p.a_mm_s2.y_mm * dt});
}

double off_mm(const Point2& p, const PrintSegment& s) {
  const Point2 off = offset_from(p, s.from, s.to);
  return distance({}, off);
}

// The speed's square is a parabola of time: smallest at its vertex, largest at an end.
void take_speed_error(const Piece& p, double wanted, Extreme& extreme) {
  const auto at = [&](double dt) {
    take(extreme, std::abs(speed(p, dt) / wanted - 1.0), p.t_s + dt, p.segment);
  };
  at(0.0);
  at(p.duration_s);
  const double aa = p.a_mm_s2.x_mm * p.a_mm_s2.x_mm + p.a_mm_s2.y_mm * p.a_mm_s2.y_mm;
  if (aa == 0.0) return;
  const double vertex = -(p.v_mm_s.x_mm * p.a_mm_s2.x_mm + p.v_mm_s.y_mm * p.a_mm_s2.y_mm) / aa;
  if (vertex > 0.0 && vertex < p.duration_s) at(vertex);
}

}  // namespace

PlaneState state_of(const Piece& p, double dt) {
  const auto q = [&](double x, double v, double a) { return x + dt * (v + 0.5 * a * dt); };
  return {{q(p.p_mm.x_mm, p.v_mm_s.x_mm, p.a_mm_s2.x_mm), q(p.p_mm.y_mm, p.v_mm_s.y_mm, p.a_mm_s2.y_mm)},
          {p.v_mm_s.x_mm + p.a_mm_s2.x_mm * dt, p.v_mm_s.y_mm + p.a_mm_s2.y_mm * dt}};
}

Peak largest(const std::function<double(double)>& f, double duration) {
  Peak best{0.0, f(0.0)};
  for (int n = 1; n <= kSamples; ++n)
    if (const double t = duration * n / kSamples, value = f(t); value > best.value) best = {t, value};
  double low = std::max(0.0, best.at - duration / kSamples),
         high = std::min(duration, best.at + duration / kSamples);
  for (int n = 0; n < kSteps; ++n) {  // ternary search between the neighbours of the best sample
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
  }
  if (const double t = 0.5 * (low + high), value = f(t); value > best.value) best = {t, value};
  return best;
}

void measure(const PrintJob& job, const AerosolMachine& machine, const std::vector<PrintStart>& starts,
             AerosolPlan& plan) {
  AerosolReport& r = plan.report;
  for (const Piece& p : plan.pieces) {
    for (const double dt : {0.0, p.duration_s}) {
      const Point2 v = state_of(p, dt).v_mm_s;
      take(r.axis_speed_ratio, std::max(std::abs(v.x_mm), std::abs(v.y_mm)) / machine.axis.v_max_mm_s,
           p.t_s + dt, p.segment);
    }
    take(r.axis_acceleration_ratio,
         std::max(std::abs(p.a_mm_s2.x_mm), std::abs(p.a_mm_s2.y_mm)) / machine.axis.alpha_mm_s2, p.t_s,
         p.segment);
    if (p.kind != PieceKind::kPrint && p.kind != PieceKind::kRound) continue;
    const PrintSegment& segment = job.segments[std::size_t(p.segment)];
    take_speed_error(p, segment.speed_mm_s, r.speed_error);
    const auto worst = [&](const std::function<double(double)>& f, Extreme& extreme) {
      const Peak peak = largest(f, p.duration_s);
      take(extreme, peak.value, p.t_s + peak.at, p.segment);
    };
    if (p.kind == PieceKind::kRound) {
      const PrintSegment& before = job.segments[std::size_t(p.segment - 1)];
      const auto off = [&](double dt) {
        return std::min(off_mm(state_of(p, dt).p_mm, before), off_mm(state_of(p, dt).p_mm, segment));
      };
      worst(off, r.path_error_mm);
      worst(
          off,
          r.position_error_mm);  // a rounded corner has no moving point of its own: the distance to the path
      continue;
    }
    const double dx = segment.to.x_mm - segment.from.x_mm, dy = segment.to.y_mm - segment.from.y_mm,
                 length = distance(segment.from, segment.to);
    const PrintStart& start = starts[std::size_t(p.segment)];
    worst([&](double dt) { return off_mm(state_of(p, dt).p_mm, segment); }, r.path_error_mm);
    worst(
        [&](double dt) {
          const Point2 at = state_of(p, dt).p_mm;
          const double gone = segment.speed_mm_s * (p.t_s + dt - start.t_s) / length;
          return distance({start.p_mm.x_mm + gone * dx, start.p_mm.y_mm + gone * dy}, at);
        },
        r.position_error_mm);
  }
}

}  // namespace firn::motion
