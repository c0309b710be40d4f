// PathPlannerNode computes the motions and pulses of the next interval: CONTROL_SURFACE -> TRAJECTORY,
// PULSE_LIST, PATH_JOB.
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

/// Sends batches. A batch holds the deposition paths of the next interval's layers in their order, then the
/// measurement paths of the last of these layers. The first batch is sent at the start of the run, with u = 0
/// (with ice.map_table: only the paths that measure the bare table as layer 0). Each further batch answers a
/// CONTROL_SURFACE with the decision to print; a repeated CONTROL_SURFACE for the same layer (another
/// attempt) is answered with a batch of its own. Each path is sent as TRAJECTORY, PULSE_LISTs, then PATH_JOB.
/// Path and batch numbers are unique in the run. Every path of the print is checked for reach before the
/// first batch. If paths fail, a PATH_JOB reports each of them (at most 20) with layer, path, reason and
/// place, a fault stops the run, and nothing is planned. Motions independent of the action are planned ahead,
/// during the printing of the batch before.
class PathPlannerNode final : public Node {
 public:
  /// @throws std::invalid_argument: a machine that is no arm, a material without a tool, layers without
  /// deposition paths
  PathPlannerNode(const Experiment& experiment, const Machine& machine, slice::PrintPaths paths);
  void start(const Start&, Time now, Outbox&) override;
  void on(const control_surface_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;
  /// Sets the parallel loop for the planning of a batch; the result has the same bytes. The node itself
  /// starts no thread.
  void use_threads(ParallelFor parallel) { parallel_ = std::move(parallel); }

 private:
  struct Batch {
    std::vector<planning::PathTask> tasks;
  };
  Batch batch_after(int layer) const;
  bool refuse_unreachable(Outbox&);
  Batch table_batch() const;
  /// Sends the batch, then sets the batch to plan ahead: the one after `next_below` layers.
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
