#include "procs/path_planner/path_planning.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/motion/path_rests.h"
#include "core/motion/placement.h"
#include "core/slice/footprint.h"

namespace firn::planning {
namespace {

constexpr int kMostTries = 20;
constexpr double kMotionSlack = 0.02;  // three times less work; the paths of a gear take 0.6 % longer
constexpr double kReachStep_mm = 10.0;
constexpr double kCoverageCell_mm = 1.0, kWidestSpot_mm = 2.0;
constexpr double kLeastCoverage = 0.7, kMostCoverage = 1.4;  // beyond, a bead would be no bead
constexpr double kShortest_mm = 0.05;  // a line that is shorter deposits nothing and cannot be driven

double distance(const Point2& a, const Point2& b) {
  const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
  return std::sqrt(dx * dx + dy * dy);
}

double length_of(const std::vector<Point2>& p, bool closed) {
  double length = 0.0;
  for (std::size_t i = 1; i < p.size(); ++i) length += distance(p[i - 1], p[i]);
  return closed && p.size() > 1 ? length + distance(p.back(), p.front()) : length;
}

PathTask task_of(const slice::PrintPaths& paths, const slice::LayerPaths& layer, std::size_t n, const PlanningSetup& setup) {
  const slice::PathInfo& info = layer.info[n];
  PathTask t;
  t.layer = layer.layer;
  t.kind = info.kind;
  t.material = info.material;
  t.closed = info.closed;
  t.width_mm = info.width * slice::kMmPerUnit;
  t.layer_height_mm = layer.height * slice::kMmPerUnit;
  t.z_mm = layer.z * slice::kMmPerUnit + (t.deposits() ? setup.nozzle_gap_mm : 0.0);
  t.tool = t.deposits() ? paths.head.materials.at(info.material).tool : "laser";
  for (const slice::Point& p : layer.lines[n]) t.points.push_back({p.x * slice::kMmPerUnit, p.y * slice::kMmPerUnit});
  return t;
}

/// Equal pieces of a path, each open, from where the one before ends.
void divide(PathTask task, double most_mm, std::vector<PathTask>& out) {
  const double length = length_of(task.points, task.closed);
  const int pieces = int(std::ceil(length / most_mm));
  if (pieces <= 1) return out.push_back(std::move(task));
  std::vector<Point2> points = std::move(task.points);
  if (task.closed) points.push_back(points.front());
  task.closed = false;
  double done = 0.0;
  task.points = {points.front()};
  for (std::size_t i = 1, piece = 1; i < points.size();) {
    const double step = distance(points[i - 1], points[i]), end = length * double(piece) / pieces;
    if (int(piece) < pieces && done + step > end) {
      const double share = (end - done) / step;
      const Point2 cut{points[i - 1].x_mm + share * (points[i].x_mm - points[i - 1].x_mm), points[i - 1].y_mm + share * (points[i].y_mm - points[i - 1].y_mm)};
      task.points.push_back(cut);
      out.push_back(task);
      task.points = {cut};
      points[i - 1] = cut;
      done = end;
      ++piece;
    } else {
      task.points.push_back(points[i++]);
      done += step;
    }
  }
  out.push_back(std::move(task));
}

template <class T>
void put(std::string& key, const T& value) {
  key.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::int64_t PlannedTask::pulses() const {
  std::int64_t n = 0;
  for (const PlannedList& l : lists) n += std::int64_t(l.ticks.size());
  return n;
}

std::vector<Point2> subdivided(const std::vector<Point2>& p, bool closed, double step_mm) {
  std::vector<Point2> out;
  const std::size_t segments = p.size() < 2 ? 0 : p.size() - (closed ? 0 : 1);
  for (std::size_t i = 0; i < segments; ++i) {
    const Point2 &a = p[i], &b = p[(i + 1) % p.size()];
    const int parts = std::max(1, int(std::ceil(distance(a, b) / step_mm)));
    for (int k = 0; k < parts; ++k) {
      const double t = double(k) / parts;
      out.push_back({a.x_mm + t * (b.x_mm - a.x_mm), a.y_mm + t * (b.y_mm - a.y_mm)});
    }
  }
  if (!closed && !p.empty()) out.push_back(p.back());
  return out;
}

std::vector<PathTask> tasks_of(const slice::PrintPaths& paths, const slice::LayerPaths& layer, bool measurement, const PlanningSetup& setup) {
  std::vector<PathTask> tasks;
  std::shared_ptr<HeightMap> excess;
  if (!measurement && setup.coverage_window_mm > 0.0) {
    excess = std::make_shared<HeightMap>(slice::bead_coverage(layer, slice::footprint_grid(layer, kCoverageCell_mm), setup.coverage_window_mm, kWidestSpot_mm));
    for (double& c : excess->cells) c -= 1.0;
  }
  for (std::size_t n = 0; n < layer.info.size(); ++n) {
    if ((layer.info[n].kind == PathKind::kMeasurement) != measurement) continue;
    PathTask task = task_of(paths, layer, n, setup);
    if (length_of(task.points, task.closed) < kShortest_mm) continue;
    if (!measurement) {
      task.excess = excess;
      tasks.push_back(std::move(task));
      continue;
    }
    const double speed = std::min(setup.speeds.at(std::min<std::size_t>(task.material, 1)).measure_mm_s, setup.machine.speed_mm_s);
    divide(std::move(task), 0.8 * speed * setup.valve_limits.max_duration_s, tasks);
  }
  return tasks;
}

struct TaskPlanner::State {
  explicit State(PlanningSetup s)
      : setup(std::move(s)), arm(make_arm(setup.machine)), limits(motion_limits(setup.machine)), tools(firn::tools(setup.machine)) {
    options.tolerance_mm = setup.tolerance_mm;
    options.tick_s = setup.machine.tick_s;
    options.lower_bound = false;
    options.slack = kMotionSlack;
  }

  struct Motion {
    motion::PlanResult result;
    double flange_z_mm = 0.0;
    int age = 0;  ///< batches since it was met
  };

  motion::PathInput input(const PathTask& t, const std::vector<Point2>& points) const {
    motion::PathInput in;
    in.points = points;
    in.kind = t.kind;
    in.closed = t.closed;
    in.origin = setup.origin;
    in.z_mm = setup.origin_z_mm + t.z_mm;
    in.preferred = preferred_posture(setup.machine);
    if (t.tool == "laser") {
      in.tool = setup.laser;
    } else {
      const auto found = std::find_if(tools.begin(), tools.end(), [&](const motion::Tool& tool) { return tool.name == t.tool; });
      if (found == tools.end()) throw std::invalid_argument("tool \"" + t.tool + "\" is not one of the machine's");
      in.tool = *found;
    }
    return in;
  }

  /// Two tasks of the same shape at the same speed differ in the height of joint 3 alone.
  const motion::PlanResult& motion(const PathTask& t, const motion::PathInput& in) {
    std::string key;
    put(key, t.kind), put(key, t.closed), put(key, in.tool.x_mm), put(key, in.tool.y_mm), put(key, in.ceiling.path_mm_s);
    put(key, in.points.size());
    for (const Point2& p : in.points) put(key, p);
    for (const double c : in.ceiling.point_mm_s) put(key, c);
    for (const std::size_t s : in.stops) put(key, s);
    const auto [at, fresh] = motions.try_emplace(std::move(key));
    Motion& m = at->second;
    m.age = 0;
    if (fresh) {
      m.result = motion::plan(in, *arm, limits, options, work);
      m.flange_z_mm = in.z_mm - in.tool.z_mm;
      ++planned;
    }
    const double rise_mm = in.z_mm - in.tool.z_mm - m.flange_z_mm;
    Trajectory& trajectory = m.result.trajectory;
    if (rise_mm != 0.0)
      for (std::size_t n = 0; n < trajectory.samples(); ++n) trajectory.positions[n * std::size_t(trajectory.axes) + kHeightJoint] += rise_mm;
    m.flange_z_mm += rise_mm;
    return m.result;
  }

  double nominal_speed(const PathTask& t) const {
    return std::min(setup.speeds.at(std::min<std::size_t>(t.material, 1)).of(t.kind), setup.machine.speed_mm_s);
  }

  /// What the path asks of its valve at the ticks of its motion.
  deposition::FlowDemand demand(const PathTask& t, const motion::PlanResult& r, const HeightMap* action) const {
    deposition::FlowDemand d;
    d.step_s = r.trajectory.tick_s;
    d.speed_mm_s = deposition::speeds_at_ticks(r.tool, d.step_s);
    d.flow_mm3_s.resize(d.speed_mm_s.size());
    deposition::nominal_flow(t.width_mm, t.layer_height_mm, d.speed_mm_s, d.flow_mm3_s);
    if (action) {
      std::vector<double> u;
      for (const Point2& p : r.tool) u.push_back(deposition::action_at(*action, p));
      deposition::corrected_flow(d.flow_mm3_s, u, d.flow_mm3_s);
    }
    if (t.excess)
      for (std::size_t n = 0; n < d.flow_mm3_s.size(); ++n)
        d.flow_mm3_s[n] /= std::clamp(1.0 + deposition::action_at(*t.excess, r.tool[n]), kLeastCoverage, kMostCoverage);
    d.stops = r.rests;
    d.stops.erase(std::unique(d.stops.begin(), d.stops.end()), d.stops.end());
    std::erase_if(d.stops, [&](std::size_t n) { return n == 0 || n + 1 >= d.speed_mm_s.size(); });
    return d;
  }

  /// Ceilings c_i = A(x_i, y_i) of the speed version (5.9).
  void follow(const HeightMap& action, const PathTask& t, std::vector<Point2>& points, motion::SpeedCeiling& ceiling) const {
    std::vector<Point2> fine = subdivided(t.points, t.closed, setup.action_step_mm);
    std::vector<double> speed;
    bool acts = false;
    for (const Point2& p : fine) {
      const double u = deposition::action_at(action, p);
      acts = acts || u != 0.0;
      speed.push_back(control::speed_for(nominal_speed(t), u));
    }
    if (!acts) return;
    points = std::move(fine);
    ceiling = {motion::kUnlimited, std::move(speed)};
  }

  std::vector<PlannedList> lists(const deposition::PulsePlan& plan, const deposition::FlowDemand& d, const ValveSetup& valve) const {
    const deposition::DemandIntegral integral(d);
    const auto earlier = std::int32_t(std::floor(valve.latency_s / setup.valve_limits.tick_s + 0.5));
    std::vector<PlannedList> out;
    for (const deposition::PulseTrain& train : plan.trains) {
      PlannedList l;
      l.start_s = d.step_s * double(train.first_instant);
      l.volume_mm3 = integral.volume_mm3(d.step_s * double(train.last_instant)) - integral.volume_mm3(l.start_s);
      std::int32_t before = -1;
      for (const std::uint16_t tick : train.ticks) l.ticks.push_back(before = std::max(before + 1, std::int32_t(tick) - earlier));
      out.push_back(std::move(l));
    }
    return out;
  }

  static constexpr std::size_t kHeightJoint = 2;
  PlanningSetup setup;
  std::unique_ptr<motion::Arm> arm;
  motion::MotionLimits limits;
  std::vector<motion::Tool> tools;
  motion::PlanOptions options;
  motion::PlanWorkspace work;
  std::map<std::string, Motion> motions;
  std::size_t planned = 0;
};

TaskPlanner::TaskPlanner(PlanningSetup setup) {
  if (setup.machine.kind != "scara") throw std::invalid_argument("machine.kind = \"" + setup.machine.kind + "\": paths are planned for an arm, \"scara\"");
  if (setup.valves.size() < 2) throw std::invalid_argument("two valves are needed, for part and scaffold");
  deposition::check(setup.valve_limits);
  for (const ValveSetup& v : setup.valves) deposition::check(v.setting, setup.valve_limits);
  if (!(setup.action_step_mm > 0.0)) throw std::invalid_argument("action_step_mm must be above 0");
  state_ = std::make_unique<State>(std::move(setup));
}

TaskPlanner::~TaskPlanner() = default;

std::size_t TaskPlanner::motions_planned() const { return state_->planned; }

void TaskPlanner::next_batch() {
  std::erase_if(state_->motions, [](const auto& entry) { return entry.second.age > 0; });
  for (auto& [key, motion] : state_->motions) ++motion.age;
}

std::string TaskPlanner::unreachable(const PathTask& task) const {
  try {
    const std::vector<Point2> points = subdivided(task.points, task.closed, kReachStep_mm);
    const motion::PathInput in = state_->input(task, points);
    motion::posture_for(motion::clean(in), in, *state_->arm);
    return {};
  } catch (const std::exception& e) {
    return e.what();
  }
}

void TaskPlanner::prepare(const PathTask& task) {
  motion::PathInput in = state_->input(task, task.points);
  in.ceiling.path_mm_s = state_->nominal_speed(task);
  state_->motion(task, in);
}

PlannedTask TaskPlanner::plan(const PathTask& task, const HeightMap* action) {
  State& s = *state_;
  PlannedTask out;
  std::vector<Point2> points = task.points;
  std::vector<double> no_yaw;
  motion::SpeedCeiling ceiling{s.nominal_speed(task), {}};
  if (task.deposits() && action && s.setup.version == control::SurfaceVersion::kPathSpeed) s.follow(*action, task, points, ceiling);
  std::vector<std::size_t> stops;
  for (int tries = 0; tries < kMostTries; ++tries) {
    motion::PathInput in;
    try {
      in = s.input(task, points);
    } catch (const std::invalid_argument& e) {
      out.problem = e.what();
      return out;
    }
    in.ceiling = ceiling;
    in.stops = stops;
    const motion::PlanResult& r = s.motion(task, in);
    if (!r.ok()) {
      out.problem = motion::describe(*r.fault);
      return out;
    }
    out.trajectory = r.trajectory;
    out.tool = r.tool;
    out.length_mm = length_of(task.points, task.closed);
    if (!task.deposits()) return out;
    const ValveSetup& valve = s.setup.valves.at(std::min<std::size_t>(task.material, s.setup.valves.size() - 1));
    deposition::FlowDemand demand = s.demand(task, r, action);
    out.clipped_mm3 = deposition::clip_flow(demand, deposition::max_flow_mm3_s(valve.setting, s.setup.valve_limits)).volume_mm3;
    const deposition::PulsePlan pulses = deposition::plan_pulses(demand, valve.setting, s.setup.valve_limits);
    if (pulses.problem.empty()) {
      out.volume_mm3 = deposition::DemandIntegral(demand).total_volume_mm3();
      out.lists = s.lists(pulses, demand, valve);
      return out;
    }
    out.problem = pulses.problem;
    const motion::UndividedSpan span{demand.speed_mm_s, demand.step_s, pulses.problem_from, pulses.problem_to, pulses.problem_fits};
    if (span.fits <= span.from || motion::add_rests(points, task.closed, ceiling, no_yaw, span, stops).empty()) break;
    out.problem.clear();
  }
  if (out.problem.empty()) out.problem = "its pulses do not fit the lists of the valve's controller";
  return {std::move(out.problem), {}, {}, {}, 0.0, 0.0, 0.0};
}

}  // namespace firn::planning
