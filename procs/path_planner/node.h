// path_planner: CONTROL_SURFACE -> TRAJECTORY, PULSE_LIST, PATH_JOB of the next interval.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "config/machine.h"
#include "core/planning/path_planning.h"
#include "firn/control_surface_t.hpp"
#include "runtime/node.h"

namespace firn {

/// A batch is the deposition paths of the next interval's layers in their order, then the measurement paths
/// of its last layer. The first is sent at the start of the run, with u = 0 (with ice.map_table: the paths
/// that measure the bare table as layer 0, alone), each further one in answer to a CONTROL_SURFACE that says
/// print; one that comes again for the same layer (another attempt) is answered with a batch of its own. Each
/// path: its TRAJECTORY, its PULSE_LISTs, then its PATH_JOB. Path and batch numbers are unique in the run.
/// Before anything is sent every path of the print is checked for reach; if one fails, a PATH_JOB tells each
/// (at most 20) with layer, path, reason and place, a fault stops the run, and nothing is planned. Motions
/// that no action changes are planned ahead, while the batch before is printed.
class PathPlannerNode final : public Node {
 public:
  /// @throws std::invalid_argument: a machine that is no arm, a material without a tool, layers without
  /// deposition paths
  PathPlannerNode(const Experiment& experiment, const Machine& machine, slice::PrintPaths paths);
  void start(const Start&, Time now, Outbox&) override;
  void on(const control_surface_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;
  /// What a batch may do side by side, with the same bytes; the node itself starts no thread.
  void use_threads(ParallelFor parallel) { parallel_ = std::move(parallel); }

 private:
  struct Batch {
    std::vector<planning::PathTask> tasks;
  };
  Batch batch_after(int layer) const;
  bool refuse_unreachable(Outbox&);
  Batch table_batch() const;
  /// And plans ahead what may come next: the batch after `next_below` layers.
  void send_batch(const Batch& batch, int next_below, std::int64_t map_id, const HeightMap* action, Outbox&);
  void send_path(const planning::PathTask& task, const planning::PlannedTask& planned, int index, int count,
                 std::int64_t map_id, Outbox&);

  slice::PrintPaths paths_;
  planning::PlanningSetup setup_;
  std::unique_ptr<planning::TaskPlanner> planner_;
  int interval_layers_;
  bool map_table_;
  ParallelFor parallel_ = serially;
  bool motions_keep_;  ///< no action changes them: the frequency version, or open loop
  std::int64_t path_ = 0, batch_ = 0;
  int answered_layer_ = 0, answered_attempt_ = -1;
  Batch ahead_;
  std::size_t ahead_next_ = 0;  ///< of ahead_.tasks
};

std::unique_ptr<Node> make_path_planner(const std::string& config_toml, const Blobs& blobs);
std::unique_ptr<Node> make_path_planner_on(const ParallelFor& parallel, const std::string& config_toml,
                                           const Blobs& blobs);

}  // namespace firn
