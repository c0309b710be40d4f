#include "procs/path_planner/node.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "config/ice_lab.h"
#include "core/grid/decision.h"
#include "core/planning/path_reach.h"
#include "firn/enums.h"
#include "firn/path_job_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr TimerId kAhead{1};
constexpr double kAheadAfter_s = 0.001;
constexpr std::size_t kMaxRefusals = 20;
constexpr double kMissingShare = 0.01;

path_job_t job_of(const planning::PathTask& t) {
  path_job_t job{};
  job.layer = t.layer;
  job.material = std::int8_t(t.material);
  job.kind = std::int8_t(t.kind);
  job.valve = std::int8_t(!t.deposits() ? ValveId::kNone : t.material == 0 ? ValveId::kA : ValveId::kB);
  job.z_mm = t.z_mm;
  return job;
}

void set_reach(path_job_t& job, const std::vector<Point2>& points) {
  if (points.empty()) return;
  const auto [x0, x1] = std::minmax_element(points.begin(), points.end(),
                                            [](const Point2& a, const Point2& b) { return a.x_mm < b.x_mm; });
  const auto [y0, y1] = std::minmax_element(points.begin(), points.end(),
                                            [](const Point2& a, const Point2& b) { return a.y_mm < b.y_mm; });
  job.x_min_mm = x0->x_mm;
  job.x_max_mm = x1->x_mm;
  job.y_min_mm = y0->y_mm;
  job.y_max_mm = y1->y_mm;
}

}  // namespace

PathPlannerNode::PathPlannerNode(const Experiment& e, const Machine& machine, slice::PrintPaths paths)
    : paths_(std::move(paths)),
      setup_(planning_setup(e, machine)),
      planner_(std::make_unique<planning::TaskPlanner>(setup_)),
      interval_layers_(e.ice.interval_layers),
      map_table_(e.ice.map_table == "on"),
      motions_keep_(setup_.version == control::SurfaceVersion::kValveFrequency ||
                    e.control.scheme == "open_loop") {
  if (paths_.layers.empty()) throw std::invalid_argument("paths: there is no layer to print");
  subscribe(channels::kControlSurface, this);
}

PathPlannerNode::Batch PathPlannerNode::batch_after(int layers_below) const {
  Batch b;
  const slice::LayerPaths* top = nullptr;
  const auto add = [&](const slice::LayerPaths& layer, bool measurement) {
    std::vector<planning::PathTask> tasks = planning::tasks_of(paths_, layer, measurement, setup_);
    std::move(tasks.begin(), tasks.end(), std::back_inserter(b.tasks));
  };
  for (const slice::LayerPaths& layer : paths_.layers) {
    if (layer.layer <= layers_below || layer.layer > layers_below + interval_layers_) continue;
    add(layer, false);
    top = &layer;
  }
  if (top) add(*top, true);
  return b;
}

PathPlannerNode::Batch PathPlannerNode::table_batch() const {
  return {planning::tasks_of(paths_, slice::table_layer(paths_), true, setup_)};
}

bool PathPlannerNode::refuse_unreachable(Outbox& out) {
  const std::vector<planning::Unreachable> refused =
      planning::unreachable_paths(*planner_, paths_, setup_, kMaxRefusals);
  for (std::size_t n = 0; n < refused.size(); ++n) {
    path_job_t job = job_of(refused[n].task);
    job.path = ++path_;
    job.batch = 1;
    job.index = std::int32_t(n);
    job.count = std::int32_t(kMaxRefusals);
    set_reach(job, refused[n].task.points);
    job.text = refused[n].text;
    out.send(channels::kPathJob, std::move(job));
  }
  if (!refused.empty()) out.report(Severity::kStop, planning::refusal(refused.front()));
  return !refused.empty();
}

void PathPlannerNode::start(const Start& start, Time, Outbox& out) {
  if (start.resumed()) return;  // the logs hold the messages sent before; receivers request them again
  if (refuse_unreachable(out)) return;
  if (map_table_) return send_batch(table_batch(), 0, 0, nullptr, out);
  send_batch(batch_after(0), interval_layers_, 0, nullptr, out);
}

void PathPlannerNode::on(const control_surface_t& m, Time, Outbox& out) {
  if (m.layer < answered_layer_ || (m.layer == answered_layer_ && m.attempt <= answered_attempt_)) return;
  answered_layer_ = m.layer;
  answered_attempt_ = m.attempt;
  if (PlanDecision(m.decision) != PlanDecision::kPrint) return;
  HeightMap action(from_message(m.grid));
  for (std::size_t c = 0; c < action.size(); ++c) action.cells[c] = double(m.u[c]);
  send_batch(batch_after(m.layer), m.layer + interval_layers_, m.map_id, &action, out);
}

void PathPlannerNode::send_batch(const Batch& batch, int next_below, std::int64_t map_id,
                                 const HeightMap* action, Outbox& out) {
  planner_->next_batch();
  if (batch.tasks.empty()) return;
  ++batch_;
  double missing_mm3 = 0.0, wanted_mm3 = 0.0;
  const std::vector<planning::PlannedTask> all = planner_->plan(batch.tasks, action, parallel_);
  for (std::size_t n = 0; n < batch.tasks.size(); ++n) {
    const planning::PlannedTask& planned = all[n];
    missing_mm3 += planned.clipped_mm3;
    wanted_mm3 += planned.volume_mm3;
    send_path(batch.tasks[n], planned, int(n), int(batch.tasks.size()), map_id, out);
  }
  if (missing_mm3 > kMissingShare * wanted_mm3)
    out.report(Severity::kWarning, "batch " + std::to_string(batch_) + " wants " +
                                       std::to_string(missing_mm3) +
                                       " mm3 more than the valves give at its speeds");
  ahead_ = batch_after(next_below);
  if (!motions_keep_) std::erase_if(ahead_.tasks, [](const planning::PathTask& t) { return t.deposits(); });
  ahead_next_ = 0;
  out.wake_at(kAhead, out.now().after_s(kAheadAfter_s));
}

void PathPlannerNode::send_path(const planning::PathTask& task, const planning::PlannedTask& planned,
                                int index, int count, std::int64_t map_id, Outbox& out) {
  path_job_t job = job_of(task);
  job.path = ++path_;
  job.batch = batch_;
  job.index = index;
  job.count = count;
  job.map_id = map_id;
  job.text = planned.problem;
  set_reach(job, planned.problem.empty() ? planned.tool : task.points);
  if (planned.problem.empty()) {
    PlannedPath path{task.layer, task.material, task.kind, planned.length_mm, planned.trajectory};
    path.trajectory.id = path_;
    out.send(channels::kTrajectory, to_message(path));
    for (std::size_t n = 0; n < planned.lists.size(); ++n) {
      const planning::PlannedList& l = planned.lists[n];
      pulse_list_t list{};
      list.path = path_;
      list.list = std::int32_t(n);
      list.lists = std::int32_t(planned.lists.size());
      list.valve = job.valve;
      list.start_s = l.start_s;
      list.tick_s = setup_.valve_limits.tick_s;
      list.pulse_s = setup_.valves[std::min<std::size_t>(task.material, 1)].setting.pulse_s;
      list.volume_mm3 = l.volume_mm3;
      list.n = std::int32_t(l.ticks.size());
      list.tick = l.ticks;
      out.send(channels::kPulseList, std::move(list));
    }
    job.lists = std::int32_t(planned.lists.size());
    job.pulses = planned.pulses();
    job.duration_s = planned.trajectory.certificate.duration_s;
    job.length_mm = planned.length_mm;
    job.volume_mm3 = planned.volume_mm3;
  }
  out.send(channels::kPathJob, std::move(job));
}

void PathPlannerNode::wake(TimerId timer, Time now, Outbox& out) {
  if (timer != kAhead || ahead_next_ >= ahead_.tasks.size()) return;
  const int layer = ahead_.tasks[ahead_next_].layer;  // one layer a step
  const std::size_t first = ahead_next_;
  while (ahead_next_ < ahead_.tasks.size() && ahead_.tasks[ahead_next_].layer == layer) ++ahead_next_;
  planner_->prepare(std::span(ahead_.tasks).subspan(first, ahead_next_ - first), parallel_);
  if (ahead_next_ < ahead_.tasks.size()) out.wake_at(kAhead, now.after_s(kAheadAfter_s));
}

std::unique_ptr<Node> make_path_planner(const std::string& config_toml, const Blobs& blobs) {
  return make_path_planner_on(serially, config_toml, blobs);
}

std::unique_ptr<Node> make_path_planner_on(const ParallelFor& parallel, const std::string& config_toml,
                                           const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  const std::vector<std::byte>& machine = blob(blobs, "machine").bytes;
  auto node = std::make_unique<PathPlannerNode>(
      e, parse_machine(std::string(reinterpret_cast<const char*>(machine.data()), machine.size()), "machine"),
      slice::decode_print_paths(blob(blobs, "paths").bytes));
  node->use_threads(parallel);
  return node;
}

}  // namespace firn
