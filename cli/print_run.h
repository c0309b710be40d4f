// print_experiment() carries out a print that is checked and has its inputs: in one process, or live.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/folder/run_folder.h"
#include "print/labs/print_labs.h"
#include "print/operator/operator_order.h"

namespace firn {

struct PrintOptions {
  std::string experiment;              ///< file; empty with `resume`
  std::string resume;                  ///< run folder
  std::string bus;                     ///< "" = live on the run's own port, "in-process", or an LCM URL
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
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
  bool page = false;  ///< in a browser too; default: with a terminal, if the program is built
  bool no_page = false;
  bool json = false;
};

/// Result of a print.
struct PrintSummary {
  std::string folder;    ///< of the run, where it is now
  bool deleted = false;  ///< the run folder was deleted during the print; `folder` is its old name
  std::string scheme;
  RunResult result;
  double wall_s = 0.0;
  double node_s = 0.0;
  bool measured = false;  ///< a map was measured in this incarnation; then, of the last one:
  double mean_error_um = 0.0, rms_um = 0.0, std_um = 0.0;
  double rms_inside_um = 0.0, rms_rim_um = 0.0;  ///< 0: not told
  std::int64_t cells_guessed = 0;                ///< of the part, without a sample
  std::int64_t rows_lost = 0;                    ///< of all scans of this incarnation
  std::int64_t droplets = 0;                     ///< or whatever `words` calls the amount
  PrintWords words;
  double tolerance_um =
      0.0;  ///< that the last map's RMS is judged by; 0 = the scheme prints towards no target
  bool tolerance_asked = false;  ///< by --tolerance: a print without a map is no success then
};

/// Prints `experiment`; `bus` as in PrintOptions. Shows progress on stderr. A live print's scans are slowed,
/// or refused, by the rate that this machine keeps up with (print/live/row_rehearsal.h).
PrintSummary print_experiment(const Experiment& experiment, const Blobs& inputs, const PrintOptions& options);

/// Steps of it, for firn print, which resumes and detaches too.
///
/// Refuses a print that no process can carry out. @throws UsageError
void check_request(const Experiment& experiment, const Blobs& inputs, const PrintOptions& options);
/// Sets the speed at which this machine reads every row.
void slow_to_rows(Experiment& experiment, const PrintOptions& options);
/// Makes the run folder. @throws UsageError: no room for the inputs, so that the print has not begun
RunFolder make_run_folder(const Experiment& experiment, const Blobs& inputs, const PrintOptions& options);
PrintSummary carry_out_print(const RunFolder& run, const Experiment& experiment, const PrintOptions& options,
                             bool resume);
/// Returns the orders of the operator that come with --resume.
std::vector<OperatorOrder> orders_with_resume(const PrintOptions& options);

}  // namespace firn
