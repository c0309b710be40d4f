// identify_runs() computes one model from several runs of the same lab, with intervals by leaving one run
// out.
#pragma once

#include <string>
#include <vector>

#include "estimators/bead/bead_law.h"
#include "studies/identify/identify.h"

namespace firn {

struct PooledConstant {
  std::string name;
  bool length = false;  ///< in mm; else a number
  double value = 0.0;   ///< of all runs
  double half_width = 0.0;
  std::vector<double> without = {};               ///< without each run
  std::vector<std::string> runs_without_it = {};  ///< they do not tell it: at its bound, at its prior
};

/// Runs are independent of each other. Layers of a run are not, so that an interval from one run is of its
/// own noise alone, and does not hold what differs from print to print: ink, nozzle, calibration.
struct PooledIdentification {
  std::vector<PooledConstant> constants;
  std::string uninformative;  ///< "RUN: reason" of the first run that does not tell its model; "" = none
};

/// ln dh = a ln v + b, of the beads of all runs together and of all but one.
/// @param runs beads of each, sorted by layer @param names of the runs, for messages
/// @throws UsageError naming the run: fewer than two runs, fewer than three beads
PooledIdentification pool(const std::vector<std::vector<bead::Bead>>& runs,
                          const std::vector<std::string>& names);

/// h1, h2, h3 and the layer height: means over the runs, each identified by itself.
/// @throws UsageError: fewer than two runs
PooledIdentification pool(const std::vector<Identification>& runs, const std::vector<std::string>& names);

}  // namespace firn
