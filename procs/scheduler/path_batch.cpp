#include "procs/scheduler/path_batch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/path/path.h"
namespace firn {
namespace {

constexpr std::size_t kMaxEarly = 100'000;

bool is_here(const PathTask& t) { return t.job.count > 0; }

bool take(PathTask& task, const pulse_list_t& list) {
  if (!is_here(task) || task.job.path != list.path || list.list < 0 ||
      std::size_t(list.list) >= task.list_start_s.size())
    return false;
  task.list_start_s[std::size_t(list.list)] = list.start_s;
  task.list_pulses[std::size_t(list.list)] = list.n;
  return true;
}

}  // namespace

void PathBatch::add(const path_job_t& job) {
  if (job.batch < number_) return;
  if (job.batch > number_) {
    number_ = job.batch;
    map_id_ = job.map_id;
    missing_ = job.count;
    tasks_.assign(std::size_t(job.count), PathTask{});
    for (PathTask& t : tasks_) t.job.count = 0;
  }
  if (std::size_t(job.count) != tasks_.size() || is_here(tasks_[std::size_t(job.index)])) return;
  PathTask& task = tasks_[std::size_t(job.index)];
  task.job = job;
  task.list_start_s.assign(std::size_t(job.lists), -1.0);
  task.list_pulses.assign(std::size_t(job.lists), 0);
  --missing_;
  std::erase_if(early_, [&](const pulse_list_t& list) { return take(task, list); });
}

void PathBatch::add(const pulse_list_t& list) {
  for (PathTask& t : tasks_)
    if (take(t, list)) return;
  if (early_.size() >= kMaxEarly) early_.erase(early_.begin());  // of paths that no job ever named
  pulse_list_t head = list;
  head.tick.clear();
  early_.push_back(std::move(head));
}

bool PathBatch::complete() const {
  return number_ > 0 && missing_ == 0 && std::ranges::all_of(tasks_, [](const PathTask& t) {
           return !t.job.text.empty() ||
                  std::ranges::all_of(t.list_start_s, [](double s) { return s >= 0.0; });
         });
}

std::string PathBatch::refusal() const {
  for (const PathTask& t : tasks_)
    if (is_here(t) && !t.job.text.empty())
      return "path " + std::to_string(t.job.path) + " of layer " + std::to_string(t.job.layer) + ": " +
             t.job.text;
  return "";
}

std::vector<PathTask> PathBatch::of_kind(bool measurement) const {
  std::vector<PathTask> out;
  for (const PathTask& t : tasks_)
    if ((PathKind(t.job.kind) == PathKind::kMeasurement) == measurement) out.push_back(t);
  return out;
}
std::vector<PathTask> PathBatch::deposition() const { return of_kind(false); }
std::vector<PathTask> PathBatch::measurement() const { return of_kind(true); }

Violation scrape(const path_job_t& job, const HeightMap& map, double margin_mm) {
  const GridSpec& g = map.spec;
  double highest = -std::numeric_limits<double>::infinity();
  int unknown = 0;
  const int i0 = std::max(0, int(std::floor((job.x_min_mm - g.origin_x_mm) / g.pitch_x_mm)));
  const int i1 = std::min(g.nx - 1, int(std::ceil((job.x_max_mm - g.origin_x_mm) / g.pitch_x_mm)));
  const int j0 = std::max(0, int(std::floor((job.y_min_mm - g.origin_y_mm) / g.pitch_y_mm)));
  const int j1 = std::min(g.ny - 1, int(std::ceil((job.y_max_mm - g.origin_y_mm) / g.pitch_y_mm)));
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i)
      if (std::isfinite(map.at(i, j)))
        highest = std::max(highest, map.at(i, j));
      else
        ++unknown;
  const std::string clearance = "the clearance of " + std::to_string(margin_mm) + " mm under the nozzle";
  if (unknown > 0)
    return {std::to_string(unknown) + " cells of the map have no height and count as high: " + clearance +
            " cannot be shown"};
  const double overlap_mm = highest + margin_mm - job.z_mm;
  if (overlap_mm <= 0.0) return {};
  return {"the map reaches " + std::to_string(overlap_mm) + " mm into " + clearance,
          {job.z_mm - highest, margin_mm, "mm", "ice.clearance_mm"}};
}

}  // namespace firn
