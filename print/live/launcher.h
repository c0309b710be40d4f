// Runs one print as small processes: starts them, waits until all are ready, watches them, makes the lab safe
// when one dies, ends them. It decides nothing about the print itself.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "print/labs/product.h"
#include "print/operator/operator_order.h"
#include "print/simulated/lab_fault.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"

namespace firn {

struct LaunchOptions {
  const runs::RunLock* lock = nullptr;  ///< of the run, held by the caller; null: the print takes it
  bool resume = false;
  std::vector<OperatorOrder> orders = {};  ///< given when all have begun: --accept-doubt, --resume --set
  bool record = false;                     ///< ports of the instruments onto RUN/cassettes
  bool unsealed = false;                   ///< with resume: go on though the folder is not as it was sealed
  std::string bus_url;                     ///< empty: loopback, a port of the run's own
  std::filesystem::path programs;  ///< folder of the processes' programs; empty: the folder of this program
  std::vector<LabFault> faults = {};  ///< in order of time
  double ready_within_s = 30.0;       ///< wall time
  double tolerance_um = 0.0;          ///< of the last map's RMS; 0 = one nominal layer
  std::function<void(const layer_metrics_t&)> progress;
  std::function<void(const fault_t&)> warned = {};  ///< faults that do not stop the print
  std::function<void(const std::string&)> note;     ///< one sentence for the user; else stderr
  std::function<void(const std::map<std::string, int>& pids)> on_start;  ///< START was sent to all
  std::string
      page_token;  ///< not empty: the process `page` shows the print, and takes commands with this token
  std::filesystem::path page_people;  ///< of those who have tokens of their own; empty: nobody
  bool page_is_public = false;        ///< who reaches the page may read without the token
  std::function<void(const std::string& address)> on_page = {};  ///< it is reached there
};

struct LaunchReport {
  runs::RunResult result;  ///< status: 0, 1 failed, 3 safety stop, 130 Ctrl-C; reason names the process that
                           ///< died and the place
  bool ended = false;      ///< the scheduler ended the run, result.json is written; else it can be resumed
  std::size_t log_repaired = 0;       ///< messages that log.lcm lacked and the write-ahead files had
  std::filesystem::path folder = {};  ///< where the run folder is now; empty = deleted
};

/// Runs the print with the nodes of the product. In every case the run folder keeps the files that a resume
/// needs. DIR/pids names the processes while they run. DIR/clocks has a line per incarnation: its number,
/// epoch [ns of CLOCK_BOOTTIME], node time there [us], time scale, bus. Ctrl-C makes the lab safe first. A
/// process that is not ready, a full disk and a run folder that is moved or deleted stop the print with their
/// cause.
/// @throws UsageError: another print has this run, its instruments or its bus; std::runtime_error naming the
/// file of a run that cannot be resumed
LaunchReport launch(const Product& product, const runs::RunFolder& folder, const LaunchOptions& options);

}  // namespace firn
