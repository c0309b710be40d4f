// print_experiment() carries out a print that is checked and has its inputs: in one process, or live.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "config/labs.h"
#include "config/meta.h"
#include "print/labs/product.h"
#include "print/operator/operator_order.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"

namespace firn {

struct PrintOptions {
  std::string experiment;  ///< file; empty with `resume`
  std::string resume;      ///< run folder
  double height_mm = 0.0,
         width_mm = 0.0;  ///< of a picture or a mesh in the place of an experiment file; 0 = not given
  std::string lab;        ///< file of the lab that prints it; "" = the ink-jet lab
  std::string bus;        ///< "" = live on the run's own port, "in-process", or an LCM URL
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  std::vector<std::string> meta;       ///< --meta KEY=VALUE
  Meta meta_values = {};               ///< of the experiment and of `meta`, for the run folder
  double speedup = 0.0;  ///< node time runs so many times faster than the clock; 0 = run.time_scale
  std::vector<std::string> faults;  ///< --fault
  std::string runs = "runs";        ///< where run folders go
  double tolerance_um = 0.0;        ///< --tolerance: RMS above it is no success; 0 = one nominal layer
  bool accept_doubt = false;
  bool plain = false;                       ///< the records of the run stay as they were written
  std::string bringup;                      ///< result file of firn bringup; "" = LAB.bringup.json
  std::vector<std::string> accept_bringup;  ///< rows of the bring-up that are not done, or "all"
  std::string bringup_state;                ///< kept beside a print on real instruments: bringup.json
  bool record = false;                      ///< bytes at the ports of instruments go onto cassettes too
  bool detach = false;                      ///< in a process of its own
  bool unsealed = false;
  bool run_python = false;  ///< resume with Python code of another user or host
  bool page = false;        ///< in a browser too; default: with a terminal, if the program is built
  bool no_page = false;
  bool is_public = false;  ///< who reaches the page may read without the token
  bool json = false;
  std::map<int, double> foretold_layer_s = {};  ///< node time at the end of each layer, as simulated
};

/// Result of a print.
struct PrintSummary {
  std::string folder;    ///< of the run, where it is now
  bool deleted = false;  ///< the run folder was deleted during the print; `folder` is its old name
  std::string scheme;
  runs::RunResult result;
  double wall_s = 0.0;
  double node_s = 0.0;
  std::int64_t cells_guessed = 0;  ///< of the part, without a sample in the last map
  std::int64_t rows_lost = 0;      ///< of all scans of this incarnation
  std::int64_t droplets = 0;       ///< or whatever `words` calls the amount
  LabWords words;
};

/// Prints `experiment`; `bus` as in PrintOptions. Shows progress on stderr. A live print's scans are slowed,
/// or refused, by the rate that this machine keeps up with (print/live/row_rehearsal.h).
PrintSummary print_experiment(const Product& product, const Experiment& experiment, const Blobs& inputs,
                              const PrintOptions& options);

/// Steps of it, for firn print, which resumes and detaches too.
///
/// Refuses a print that no process can carry out. @throws UsageError
void check_request(const Product& product, const Experiment& experiment, const Blobs& inputs,
                   const PrintOptions& options);
/// Sets the speed at which this machine reads every row.
void slow_to_rows(Experiment& experiment, const PrintOptions& options);
/// Makes the run folder. @throws UsageError: no room for the inputs, so that the print has not begun
runs::RunFolder make_run_folder(const Experiment& experiment, const Blobs& inputs,
                                const PrintOptions& options);
/// @param lock of the run, for a print
PrintSummary carry_out_print(const Product& product, const runs::RunFolder& run, const Experiment& experiment,
                             const PrintOptions& options, bool resume, const runs::RunLock& lock);
/// Packs the records of a print that is over and whose verdict was told, unless options.plain. Shows its
/// progress on stderr. Ctrl-C leaves the rest plain; nothing that happens here changes the verdict.
void pack_print(const PrintSummary& print, const PrintOptions& options);
/// Returns the orders of the operator that come with --resume.
std::vector<OperatorOrder> orders_with_resume(const PrintOptions& options);

}  // namespace firn
