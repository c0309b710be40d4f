#include "print/prepare/plan_job.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>
#include <utility>

#include "core/path/rounding.h"
#include "core/path/trajectory_codec.h"
#include "files/nearest.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kBatchPoints = 100000, kBatchPaths = 4096;

double length_of(const Path& path) {
  double length = 0.0;
  const std::vector<Point2>& p = path.points;
  for (std::size_t i = 1; i < p.size(); ++i)
    length += std::hypot(p[i].x_mm - p[i - 1].x_mm, p[i].y_mm - p[i - 1].y_mm);
  if (path.closed && p.size() > 1)
    length += std::hypot(p.front().x_mm - p.back().x_mm, p.front().y_mm - p.back().y_mm);
  return length;
}

}  // namespace

struct PlanJob::State {
  State(const Machine& machine, const PlanJobOptions& o, PlannedSink s)
      : options(o),
        sink(std::move(s)),
        arm(make_arm(machine)),
        limits(motion_limits(machine)),
        configuration(preferred_configuration(machine)),
        all_tools(tools(machine)),
        valve(machine.valve),
        workspaces(std::size_t(std::max(1, o.threads))) {}

  const motion::Tool& tool(const InputPath& path) const {
    const auto found = std::find_if(all_tools.begin(), all_tools.end(),
                                    [&](const motion::Tool& t) { return t.name == path.tool; });
    if (found != all_tools.end()) return *found;
    std::vector<std::string_view> names;
    for (const motion::Tool& t : all_tools) names.push_back(t.name);
    const std::string near = nearest(path.tool, names);
    throw UsageError(path.place + ": tool \"" + path.tool + "\" is not one of the machine's" +
                     (near.empty() ? "" : "; the nearest known one is " + near));
  }

  void plan_one(PlannedItem& item, motion::PlanWorkspace& work) const {
    const InputPath& in = item.input;
    motion::PathInput path;
    path.points = in.path.points;
    path.closed = in.path.closed;
    path.origin = options.origin;
    path.z_mm = in.path.z_mm;
    path.yaw_rad = in.yaw_rad;
    path.yaw_point_rad = in.yaw_point_rad;
    path.tool = tool(in);
    path.speed_limit = in.speed_limit;
    path.preferred = configuration;
    path.kind = in.path.kind;
    path.given = in.given;
    motion::PlanOptions how = options.plan;
    how.point_noise_mm = options.point_noise_mm.value_or(rounding_mm(path.points));
    if (in.number != options.traced) how.trace_step_s = 0.0;
    item.length_mm = length_of(in.path);
    item.result = motion::plan(path, *arm, limits, how, work);
    if (item.result.ok() && options.pulses) plan_pulses(item, path, how, work);
    if (!item.result.ok()) return;
    PlannedPath planned{in.path.layer, in.path.material, in.path.kind, item.length_mm,
                        std::move(item.result.trajectory)};
    planned.trajectory.id = in.number;
    item.encoded = encode(planned);
    item.result.trajectory = std::move(planned.trajectory);
    if (options.describe) options.describe(item);
    if (!options.keep_tool && in.number != options.traced) item.result.tool = {};
  }

  // Plans again with more rests until the pulses fit the controller's lists.
  void plan_pulses(PlannedItem& item, motion::PathInput& path, const motion::PlanOptions& how,
                   motion::PlanWorkspace& work) const {
    constexpr int kMaxTries = 100;
    for (int tries = 0; item.result.ok(); ++tries) {
      try {
        item.pulse_plan = nominal_pulses(item.input, item.result, valve);
      } catch (const std::runtime_error& e) {
        item.problem = e.what();
        return;
      }
      if (item.pulse_plan.problem.empty()) return;
      std::vector<AddedStop> added;
      if (how.method != motion::Method::kDefault && tries < kMaxTries)
        added =
            add_stops(item.input, nominal_demand(item.input.path, item.result), item.pulse_plan, path.stops);
      if (added.empty()) {
        item.problem = item.input.place + ": " + item.pulse_plan.problem;
        return;
      }
      item.added_stops.insert(item.added_stops.end(), added.begin(), added.end());
      path.points = item.input.path.points;
      path.given = {};  // a new point on a chord of an arc is not on the arc
      path.speed_limit = item.input.speed_limit;
      path.yaw_point_rad = item.input.yaw_point_rad;
      item.result = motion::plan(path, *arm, limits, how, work);
    }
  }

  // Runs beside the reading of the next batch; each worker plans the next unclaimed path.
  void start() {
    next = 0;
    failure = nullptr;
    for (std::size_t n = 0; n < workspaces.size(); ++n)
      workers.emplace_back([this, n] {
        try {
          for (std::size_t i = next++; i < running.size(); i = next++) plan_one(running[i], workspaces[n]);
        } catch (...) {
          if (!failed.test_and_set()) failure = std::current_exception();
        }
      });
  }

  void collect() {
    for (std::thread& w : workers) w.join();
    workers.clear();
    failed.clear();
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
    for (PlannedItem& item : running) sink(std::move(item));
    running.clear();
  }

  PlanJobOptions options;
  PlannedSink sink;
  std::unique_ptr<motion::Arm> arm;
  motion::MotionLimits limits;
  motion::ArmConfiguration configuration;
  std::vector<motion::Tool> all_tools;
  ValveConfig valve;
  std::vector<motion::PlanWorkspace> workspaces;  // one per thread, kept between batches
  std::vector<PlannedItem> gathered, running;
  std::size_t points = 0;
  std::vector<std::thread> workers;
  std::atomic<std::size_t> next{0};
  std::atomic_flag failed;
  std::exception_ptr failure;
};

PlanJob::PlanJob(const Machine& machine, const PlanJobOptions& options, PlannedSink sink)
    : state_(std::make_unique<State>(machine, options, std::move(sink))) {}

PlanJob::~PlanJob() {
  for (std::thread& w : state_->workers) w.join();
}

void PlanJob::add(InputPath&& path) {
  State& s = *state_;
  s.tool(path);
  s.points += path.path.points.size();
  s.gathered.emplace_back().input = std::move(path);
  if (s.points < kBatchPoints && s.gathered.size() < kBatchPaths) return;
  s.collect();
  std::swap(s.running, s.gathered);
  s.points = 0;
  s.start();
}

void PlanJob::finish() {
  State& s = *state_;
  s.collect();
  std::swap(s.running, s.gathered);
  s.start();
  s.collect();
}

}  // namespace firn
