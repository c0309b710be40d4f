#include "core/motion/aerosol/plan.h"

#include <algorithm>
#include <cmath>

#include "core/motion/aerosol/builder.h"
#include "core/motion/aerosol/check.h"
#include "core/motion/aerosol/measure.h"
#include "core/motion/aerosol/rounding.h"

namespace firn::motion {
namespace {

constexpr double kLoopTolerance_mm =
    0.001;  // loop mode keeps the shutter open for turns that round within 1 um

// Transition from segment i to segment i + 1.
enum class Joint : std::uint8_t { kApart, kAverage, kRound, kLoop };

constexpr double kStraight = 1.0 - 1e-9;  // cosine of a turn between two speeds of one straight line

struct Corners {
  std::vector<Joint> joint;        // n - 1
  std::vector<Rounding> rounding;  // n - 1, filled where kRound
};

double length(const PrintSegment& s) { return distance(s.from, s.to); }

// Unit vector; (40) to (47) without their case distinction.
Point2 direction(const PrintSegment& s) {
  const double l = length(s);
  return {(s.to.x_mm - s.from.x_mm) / l, (s.to.y_mm - s.from.y_mm) / l};
}
Point2 velocity(const PrintSegment& s) {
  const Point2 d = direction(s);
  return {s.speed_mm_s * d.x_mm, s.speed_mm_s * d.y_mm};
}

// Greedy in printing order: a rounding takes its tangent from both segments, and the rest of a segment's
// length is available to the next corner.
Corners decide_corners(const PrintJob& job, const AerosolMachine& machine, const AerosolOptions& options) {
  const std::size_t joints = job.segments.empty() ? 0 : job.segments.size() - 1;
  Corners c{std::vector<Joint>(joints, Joint::kApart), std::vector<Rounding>(joints)};
  const double tolerance = options.corner == CornerMode::kHybrid
                               ? std::max(options.tolerance_mm, kLoopTolerance_mm)
                               : kLoopTolerance_mm;
  double used_mm = 0.0;  // of segment i, at its begin
  for (std::size_t i = 0; i < joints; ++i) {
    const PrintSegment &a = job.segments[i], &b = job.segments[i + 1];
    const double left_mm = length(a) - used_mm;
    used_mm = 0.0;
    if (!coincide(a.to, b.from)) continue;
    c.joint[i] = options.corner == CornerMode::kPaper ? Joint::kAverage : Joint::kLoop;
    const Point2 from = direction(a), to = direction(b);
    if (options.blend_speeds && a.speed_mm_s != b.speed_mm_s &&
        from.x_mm * to.x_mm + from.y_mm * to.y_mm > kStraight) {
      c.joint[i] = Joint::kAverage;
      continue;
    }
    const bool back =
        from.x_mm * to.x_mm + from.y_mm * to.y_mm <= -0.99;  // a rounding needs room without bound
    if (options.corner == CornerMode::kPaper || back || a.speed_mm_s != b.speed_mm_s) continue;
    Rounding r = round_corner(from, to, a.speed_mm_s, machine.axis.alpha_mm_s2);
    if (r.deviation_mm > tolerance || r.tangent_mm > left_mm || r.tangent_mm > length(b)) continue;
    c.joint[i] = Joint::kRound;
    used_mm = r.tangent_mm;
    c.rounding[i] = std::move(r);
  }
  return c;
}

// Boundary speeds of segment i: its own (48), (49), or the mean with its neighbour's (52), (53).
struct Ends {
  Point2 v0, v1;
};
Ends boundary_speeds(const PrintJob& job, const Corners& corners, std::size_t i) {
  const Point2 own = velocity(job.segments[i]);
  const auto mean = [&](std::size_t other) {
    const Point2 v = velocity(job.segments[other]);
    return Point2{0.5 * (own.x_mm + v.x_mm), 0.5 * (own.y_mm + v.y_mm)};
  };
  Ends e{own, own};
  if (i > 0 && corners.joint[i - 1] == Joint::kAverage) e.v0 = mean(i - 1);
  if (i + 1 < job.segments.size() && corners.joint[i] == Joint::kAverage) e.v1 = mean(i + 1);
  return e;
}

class Planner {
 public:
  Planner(const PrintJob& job, const AerosolMachine& machine, const AerosolOptions& options)
      : job_(job), machine_(machine), corners_(decide_corners(job, machine, options)), build_(machine) {}

  AerosolPlan run() {
    const std::int32_t count = std::int32_t(job_.segments.size());
    double closed_at_least = machine_.shutter_delay_s;  // closed at the start: it only has to open
    for (std::int32_t i = 0; i < count; ++i) {
      const std::size_t n = std::size_t(i);
      const Joint before = i == 0 ? Joint::kApart : corners_.joint[n - 1];
      const Ends ends = boundary_speeds(job_, corners_, n);
      if (before == Joint::kApart || before == Joint::kLoop)
        build_.transit(before == Joint::kLoop ? PieceKind::kLoop : PieceKind::kTransit, i,
                       job_.segments[n].from, ends.v0, closed_at_least);
      if (before == Joint::kRound) build_.round(i, job_.segments[n].from, corners_.rounding[n - 1]);
      print(i, ends);
      closed_at_least = 2.0 * machine_.shutter_delay_s;
    }
    build_.transit(PieceKind::kTransit, count, job_.end, {0, 0}, count ? machine_.shutter_delay_s : 0.0);
    AerosolPlan plan = build_.finish();
    if (plan.ok()) measure(job_, machine_, starts_, plan);
    return plan;
  }

  void start() { build_.begin(job_.start); }

 private:
  void print(std::int32_t i, const Ends& ends) {
    const std::size_t n = std::size_t(i);
    const PrintSegment& s = job_.segments[n];
    starts_.push_back({build_.time_s(), build_.position()});
    Point2 to = s.to;
    double printed_mm = length(s);
    if (i > 0 && corners_.joint[n - 1] == Joint::kRound) printed_mm -= corners_.rounding[n - 1].tangent_mm;
    if (n + 1 < job_.segments.size() && corners_.joint[n] == Joint::kRound) {
      const double tangent = corners_.rounding[n].tangent_mm;
      const Point2 d = direction(s);
      printed_mm -= tangent;
      to = {s.to.x_mm - tangent * d.x_mm, s.to.y_mm - tangent * d.y_mm};
    }
    build_.print(i, to, ends.v0, ends.v1, std::max(0.0, printed_mm) / s.speed_mm_s);  // (50), (51)
  }

  const PrintJob& job_;
  const AerosolMachine& machine_;
  Corners corners_;
  PlanBuilder build_;
  std::vector<PrintStart> starts_;
};

}  // namespace

const char* name(CornerMode mode) {
  switch (mode) {
    case CornerMode::kPaper:
      return "paper";
    case CornerMode::kLoop:
      return "loop";
    case CornerMode::kHybrid:
      return "hybrid";
  }
  return "paper";
}

AerosolPlan plan_aerosol(const PrintJob& job, const AerosolMachine& machine, const AerosolOptions& options) {
  check_machine(machine, options);
  AerosolPlan refused;
  refused.refused = check_job(job, machine);
  if (!refused.ok()) return refused;
  Planner planner(job, machine, options);
  planner.start();
  return planner.run();
}

PlaneState state_at(const AerosolPlan& plan, double t_s) {
  if (plan.pieces.empty()) return {};
  const auto after = std::ranges::upper_bound(plan.pieces, t_s, {}, &Piece::t_s);
  const Piece& piece = after == plan.pieces.begin() ? *after : *(after - 1);
  return state_of(piece, std::clamp(t_s - piece.t_s, 0.0, piece.duration_s));
}

Trajectory sample_stage(const AerosolPlan& plan, const AerosolMachine& machine) {
  Trajectory out;
  out.tick_s = machine.tick_s;
  out.axes = 2;
  out.axis_units = {"mm", "mm"};
  const double sign = machine.substrate_moves ? -1.0 : 1.0;
  const double duration = plan.duration_s();
  const std::size_t last = std::size_t(std::ceil(duration / machine.tick_s - 1e-9));
  if (!plan.pieces.empty()) out.positions.reserve(2 * (last + 1));
  for (std::size_t n = 0; n <= last && !plan.pieces.empty(); ++n) {
    const Point2 p = state_at(plan, std::min(double(n) * machine.tick_s, duration)).p_mm;
    out.positions.push_back(machine.stage_origin.x_mm + sign * p.x_mm);
    out.positions.push_back(machine.stage_origin.y_mm + sign * p.y_mm);
  }
  const AerosolReport& r = plan.report;
  out.certificate.limits = {
      {"axis speed", r.axis_speed_ratio.value, r.axis_speed_ratio.t_s},
      {"axis acceleration", r.axis_acceleration_ratio.value, r.axis_acceleration_ratio.t_s}};
  out.certificate.duration_s = duration;
  out.certificate.lower_bound_s = r.lower_bound_s;
  return out;
}

std::vector<ShutterCommand> shutter_commands(const AerosolPlan& plan, const AerosolMachine& machine) {
  std::vector<ShutterCommand> commands;
  for (const ShutterSpan& span : plan.open) {
    commands.push_back({span.open_s - machine.shutter_delay_s, true});
    commands.push_back({span.close_s - machine.shutter_delay_s, false});
  }
  return commands;
}

}  // namespace firn::motion
