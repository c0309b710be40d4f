#include "core/planning/path_planning.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/motion/insert_stops.h"
#include "core/motion/kinematics/placement.h"
#include "core/path/polyline.h"

namespace firn::planning {
namespace {

constexpr int kMaxTries = 20;
constexpr double kMotionSlack = 0.02;  // three times less work; the paths of a gear take 0.6 % longer
constexpr double kReachStep_mm = 10.0;
constexpr double kMinCoverage = 0.7, kMaxCoverage = 1.4;  // beyond, a bead would be no bead

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

struct TaskPlanner::State {
  explicit State(PlanningSetup s) : setup(std::move(s)) {
    options.tolerance_mm = setup.tolerance_mm;
    options.tick_s = setup.arm.tick_s;
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
    in.preferred = setup.arm.preferred;
    if (t.tool == "laser") {
      in.tool = setup.laser;
    } else {
      const std::vector<motion::Tool>& tools = setup.arm.tools;
      const auto found = std::find_if(tools.begin(), tools.end(),
                                      [&](const motion::Tool& tool) { return tool.name == t.tool; });
      if (found == tools.end())
        throw std::invalid_argument("tool \"" + t.tool + "\" is not one of the machine's");
      in.tool = *found;
    }
    return in;
  }

  /// What motion is first tried for a task.
  struct FirstTry {
    std::string problem;  ///< why there is none
    std::vector<Point2> points;
    motion::PathInput in;  ///< of `points`
    std::string key;
  };

  static std::string key_of(const PathTask& t, const motion::PathInput& in) {
    std::string key;
    put(key, t.kind);
    put(key, t.closed);
    put(key, in.tool.x_mm);
    put(key, in.tool.y_mm);
    put(key, in.speed_limit.path_mm_s);
    put(key, in.points.size());
    for (const Point2& p : in.points) put(key, p);
    for (const double c : in.speed_limit.point_mm_s) put(key, c);
    for (const std::size_t s : in.stops) put(key, s);
    return key;
  }

  FirstTry first_try(const PathTask& t, const HeightMap* action) const {
    FirstTry out;
    out.points = t.points;
    motion::PathSpeedLimit speed_limit{nominal_speed(t), {}};
    if (t.deposits() && action && setup.version == control::SurfaceVersion::kPathSpeed)
      follow(*action, t, out.points, speed_limit);
    try {
      out.in = input(t, out.points);
      out.in.speed_limit = std::move(speed_limit);
      out.key = key_of(t, out.in);
    } catch (const std::invalid_argument& e) {
      out.problem = e.what();
    }
    return out;
  }

  /// Plans the motions that are not remembered, side by side: what comes of one does not depend on the
  /// others.
  void plan_motions(const std::vector<FirstTry>& tries, const ParallelFor& parallel) {
    std::vector<std::pair<const FirstTry*, Motion*>> fresh;
    for (const FirstTry& t : tries) {
      if (!t.problem.empty()) continue;
      const auto [at, is_new] = motions.try_emplace(t.key);
      at->second.age = 0;
      if (is_new) fresh.emplace_back(&t, &at->second);
    }
    planned += fresh.size();
    parallel(kStrands, [&](int strand) {
      for (std::size_t n = std::size_t(strand); n < fresh.size(); n += kStrands) {
        const motion::PathInput& in = fresh[n].first->in;
        fresh[n].second->result =
            motion::plan(in, *setup.arm.kinematics, setup.arm.limits, options, work[std::size_t(strand)]);
        fresh[n].second->flange_z_mm = in.z_mm - in.tool.z_mm;
      }
    });
  }

  /// Two tasks of the same shape at the same speed differ in the height of joint 3 alone.
  const motion::PlanResult& remembered(const FirstTry& t) {
    Motion& m = motions.at(t.key);
    const motion::PathInput& in = t.in;
    const double rise_mm = in.z_mm - in.tool.z_mm - m.flange_z_mm;
    Trajectory& trajectory = m.result.trajectory;
    if (rise_mm != 0.0)
      for (std::size_t n = 0; n < trajectory.samples(); ++n)
        trajectory.positions[n * std::size_t(trajectory.axes) + kHeightJoint] += rise_mm;
    m.flange_z_mm += rise_mm;
    return m.result;
  }

  double nominal_speed(const PathTask& t) const {
    return std::min(setup.speeds.at(std::min<std::size_t>(t.material, 1)).of(t.kind), setup.arm.speed_mm_s);
  }

  /// What the path asks of its valve at the ticks of its motion.
  deposition::FlowDemand demand(const PathTask& t, const PlannedTask& p,
                                const std::vector<std::size_t>& rests, const HeightMap* action) const {
    deposition::FlowDemand d;
    d.step_s = p.trajectory.tick_s;
    d.speed_mm_s = deposition::speeds_at_ticks(p.tool, d.step_s);
    d.flow_mm3_s.resize(d.speed_mm_s.size());
    deposition::nominal_flow(t.width_mm, t.layer_height_mm, d.speed_mm_s, d.flow_mm3_s);
    if (action) {
      std::vector<double> u;
      for (const Point2& at : p.tool) u.push_back(deposition::action_at(*action, at));
      deposition::corrected_flow(d.flow_mm3_s, u, d.flow_mm3_s);
    }
    if (t.excess)
      for (std::size_t n = 0; n < d.flow_mm3_s.size(); ++n)
        d.flow_mm3_s[n] /=
            std::clamp(1.0 + deposition::action_at(*t.excess, p.tool[n]), kMinCoverage, kMaxCoverage);
    d.stops = rests;
    d.stops.erase(std::unique(d.stops.begin(), d.stops.end()), d.stops.end());
    std::erase_if(d.stops, [&](std::size_t n) { return n == 0 || n + 1 >= d.speed_mm_s.size(); });
    return d;
  }

  /// Ceilings c_i = A(x_i, y_i) of the speed version (5.9).
  void follow(const HeightMap& action, const PathTask& t, std::vector<Point2>& points,
              motion::PathSpeedLimit& speed_limit) const {
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
    speed_limit = {motion::kUnlimited, std::move(speed)};
  }

  std::vector<PlannedList> lists(const deposition::PulsePlan& plan, const deposition::FlowDemand& d,
                                 const ValveSetup& valve) const {
    const deposition::DemandIntegral integral(d);
    const auto earlier = std::int32_t(std::floor(valve.latency_s / setup.valve_limits.tick_s + 0.5));
    std::vector<PlannedList> out;
    for (const deposition::PulseTrain& train : plan.trains) {
      PlannedList l;
      l.start_s = d.step_s * double(train.first_instant);
      l.volume_mm3 =
          integral.volume_mm3(d.step_s * double(train.last_instant)) - integral.volume_mm3(l.start_s);
      std::int32_t before = -1;
      for (const std::uint16_t tick : train.ticks)
        l.ticks.push_back(before = std::max(before + 1, std::int32_t(tick) - earlier));
      out.push_back(std::move(l));
    }
    return out;
  }

  void take(const PathTask& t, const motion::PlanResult& r, PlannedTask& out) const {
    out.trajectory = r.trajectory;
    out.tool = r.tool;
    out.length_mm = path_length_mm(t.points, t.closed);
  }

  /// Where the valve's lists do not fit the motion; `fits` if they do.
  struct Undivided {
    std::string problem;
    motion::UndividedSpan span;
    std::vector<double> speed_mm_s;
    bool fits() const { return problem.empty(); }
  };

  /// The pulses of a planned motion.
  Undivided lay(const PathTask& t, const std::vector<std::size_t>& rests, const HeightMap* action,
                PlannedTask& out) const {
    const ValveSetup& valve = setup.valves.at(std::min<std::size_t>(t.material, setup.valves.size() - 1));
    deposition::FlowDemand d = demand(t, out, rests, action);
    out.clipped_mm3 =
        deposition::clip_flow(d, deposition::max_flow_mm3_s(valve.setting, setup.valve_limits)).volume_mm3;
    const deposition::PulsePlan pulses = deposition::plan_pulses(d, valve.setting, setup.valve_limits);
    if (!pulses.problem.empty())
      return {pulses.problem,
              {{}, d.step_s, pulses.problem_from, pulses.problem_to, pulses.problem_fits},
              std::move(d.speed_mm_s)};
    out.volume_mm3 = deposition::DemandIntegral(d).total_volume_mm3();
    out.lists = lists(pulses, d, valve);
    return {};
  }

  /// A task whose pulses do not fit one list: more and more rests until every list fits.
  PlannedTask with_rests(const PathTask& t, const HeightMap* action, FirstTry first) {
    std::vector<FirstTry> once;
    once.push_back(std::move(first));
    std::vector<Point2>& points = once[0].points;
    motion::PathInput& in = once[0].in;
    std::vector<double> no_yaw;
    std::string problem;
    for (int tries = 0; tries < kMaxTries; ++tries) {
      in.points = points;
      once[0].key = key_of(t, in);
      plan_motions(once, serially);
      const motion::PlanResult& r = remembered(once[0]);
      PlannedTask out;
      if (!r.ok()) {
        out.problem = motion::describe(*r.fault);
        return out;
      }
      take(t, r, out);
      Undivided left = lay(t, r.stop_samples, action, out);
      if (left.fits()) return out;
      problem = std::move(left.problem);
      left.span.speed_mm_s = left.speed_mm_s;
      if (left.span.fits <= left.span.from ||
          motion::insert_stops(points, t.closed, in.speed_limit, no_yaw, left.span, in.stops).empty())
        break;
      problem.clear();
    }
    if (problem.empty()) problem = "its pulses do not fit the lists of the valve's controller";
    return {std::move(problem), {}, {}, {}, 0.0, 0.0, 0.0};
  }

  static constexpr std::size_t kHeightJoint = 2;
  static constexpr int kStrands = 16;  // of a batch; more than threads, since paths differ in length
  PlanningSetup setup;
  motion::PlanOptions options;
  std::array<motion::PlanWorkspace, kStrands> work;
  std::map<std::string, Motion> motions;
  std::size_t planned = 0;
};

TaskPlanner::TaskPlanner(PlanningSetup setup) {
  if (!setup.arm.kinematics) throw std::invalid_argument("paths are planned for an arm, and there is none");
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
    motion::configuration_for(motion::clean(in), in, *state_->setup.arm.kinematics);
    return {};
  } catch (const std::exception& e) {
    return e.what();
  }
}

void TaskPlanner::prepare(std::span<const PathTask> tasks, const ParallelFor& parallel) {
  std::vector<State::FirstTry> tries(tasks.size());
  for (std::size_t n = 0; n < tasks.size(); ++n) tries[n] = state_->first_try(tasks[n], nullptr);
  state_->plan_motions(tries, parallel);
}

PlannedTask TaskPlanner::plan(const PathTask& task, const HeightMap* action) {
  return std::move(plan({&task, 1}, action, serially).front());
}

std::vector<PlannedTask> TaskPlanner::plan(std::span<const PathTask> tasks, const HeightMap* action,
                                           const ParallelFor& parallel) {
  State& s = *state_;
  const auto each = [&](const auto& body) {
    parallel(State::kStrands, [&](int strand) {
      for (std::size_t n = std::size_t(strand); n < tasks.size(); n += State::kStrands) body(n);
    });
  };
  std::vector<State::FirstTry> tries(tasks.size());
  each([&](std::size_t n) { tries[n] = s.first_try(tasks[n], action); });
  s.plan_motions(tries, parallel);
  std::vector<PlannedTask> out(tasks.size());
  std::vector<std::vector<std::size_t>> rests(tasks.size());
  for (std::size_t n = 0; n < tasks.size();
       ++n) {  // in order: a remembered motion is raised from task to task
    out[n].problem = tries[n].problem;
    if (!tries[n].problem.empty()) continue;
    const motion::PlanResult& r = s.remembered(tries[n]);
    if (r.ok()) {
      rests[n] = r.stop_samples;
      s.take(tasks[n], r, out[n]);
    } else
      out[n].problem = motion::describe(*r.fault);
  }
  std::vector<char> divided(tasks.size(), 0);
  each([&](std::size_t n) {
    if (out[n].problem.empty() && tasks[n].deposits())
      divided[n] = !s.lay(tasks[n], rests[n], action, out[n]).fits();
  });
  for (std::size_t n = 0; n < tasks.size(); ++n)
    if (divided[n]) out[n] = s.with_rests(tasks[n], action, std::move(tries[n]));
  return out;
}

}  // namespace firn::planning
