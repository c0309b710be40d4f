// Runs a print with all nodes and the simulated world in this process and in simulated time. The run folder
// is that of a live print: write-ahead files, log.lcm, world.rec.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/grid/grid.h"
#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "print/labs/product.h"
#include "print/operator/operator_order.h"
#include "print/simulated/lab_fault.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"

namespace firn {

namespace plant {
struct WorldConfig;
}

using ProgressFn = std::function<void(const layer_metrics_t&)>;
/// Receives a fault that does not stop the print, for the operator.
using WarningFn = std::function<void(const fault_t&)>;

/// An order that the operator gives at a moment of node time.
struct LabOrder {
  double node_s = 0.0;
  OperatorOrder order;
};

struct LabRunOptions {
  const runs::RunLock* lock = nullptr;  ///< of the run, held by the caller; null: the print takes it
  bool resume = false;
  std::vector<OperatorOrder> orders = {};  ///< given at the beginning: --accept-doubt, --resume --set
  std::vector<LabOrder> later = {};        ///< in order of time
  bool unsealed = false;                   ///< with resume: go on though the folder is not as it was sealed
  std::uint64_t crash_after_steps = 0;  ///< fault injection: everything dies after this many steps; 0 = never
  std::vector<LabFault> faults = {};    ///< in order of time
  double tolerance_um = 0.0;            ///< of the last map's RMS; 0 = one nominal layer
  /// Changes nature beyond the keys of [plant], before the world is made.
  std::function<void(plant::WorldConfig&)> nature = {};
  ProgressFn progress;
  WarningFn warned = {};
  std::function<void(const std::string&)> note;  ///< one sentence for the user; else stderr
  std::function<bool()> interrupted;  ///< Ctrl-C: the print ends between two steps and can be resumed
};

struct LabRunReport {
  runs::RunResult result;  ///< status 3, 130: stopped by the disk, by Ctrl-C; result.json is not written
  bool crashed = false;    ///< by crash_after_steps
  std::filesystem::path folder;  ///< where the run folder is now; empty = deleted
  double node_seconds = 0.0;     ///< simulated duration
  std::uint64_t steps = 0;
  std::uint64_t messages = 0;
  std::uint64_t message_bytes = 0;
  double handler_seconds = 0.0;  ///< wall time inside the nodes' handlers
  std::int64_t now_us = 0;       ///< node time at the end
  HeightMap truth;               ///< noise-free final surface, which no node knows
};

/// Prints (or continues printing) into `run` with the nodes of the product. Writes result.json unless it was
/// stopped. The files of a print that is killed, or that finds no room on the disk, are taken back to the end
/// of its last measured layer (RunCommit), at once or by the resume.
/// @throws UsageError: another process prints this run, the folder is not as it was sealed;
/// std::runtime_error naming file and reason: unreadable inputs, a write-ahead file that does not replay.
LabRunReport run_in_lab(const Product& product, const runs::RunFolder& run, const LabRunOptions& options);

}  // namespace firn
