// PathBatch holds the paths between two answers to a height map; path_planner sends these paths one by one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/grid/figure.h"
#include "core/grid/grid.h"
#include "firn/path_job_t.hpp"
#include "firn/pulse_list_t.hpp"

namespace firn {

/// A path with the start times of its pulse lists. The robot runs the path list by list, from rest to rest.
struct PathTask {
  path_job_t job{};
  std::vector<double> list_start_s;  ///< one per list; empty for a measurement
  std::vector<std::int64_t> list_pulses;
};

/// Collects PATH_JOBs and PULSE_LISTs in any order; a newer batch replaces an older one.
class PathBatch {
 public:
  void add(const path_job_t& job);
  void add(const pulse_list_t& list);

  std::int64_t number() const { return number_; }
  std::int64_t map_id() const { return map_id_; }  ///< of the map that it answers
  /// Returns true if all jobs and all their lists have arrived.
  bool complete() const;
  /// Returns number and reason of the first refused path; empty = no path refused.
  std::string refusal() const;

  /// Return the paths in order. @pre complete()
  std::vector<PathTask> deposition() const;
  std::vector<PathTask> measurement() const;

 private:
  std::vector<PathTask> of_kind(bool measurement) const;

  std::int64_t number_ = 0, map_id_ = 0;
  int missing_ = 0;  ///< jobs
  std::vector<PathTask> tasks_;
  std::vector<pulse_list_t> early_;  ///< lists whose job is not here yet, without their ticks
};

/// I6: the map's highest cell under the box that the tool sweeps, plus the margin, must not reach the tool. A
/// cell without a height counts as high.
/// @param margin_mm ice.clearance_mm
/// @returns a violation with the clearance that is left [mm]; empty = clear
Violation scrape(const path_job_t& job, const HeightMap& map, double margin_mm);

}  // namespace firn
