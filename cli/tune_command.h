// run_tune_smf computes gains of surface-mapping feedback for a disturbance that is given or found in a run
// [Barnett 2012, 5.6].
#pragma once

#include <string>
#include <vector>

#include "core/control/smf_line/smf_line.h"
#include "print/folder/observed_run.h"

namespace firn {

/// d_k of a run's layers, in nominal layers: the mean height added over the mask, less the height that its
/// droplets were to add (n h1 + 4 n h2 + 4 n h3), over that height. Whatever scheme printed it.
/// @throws UsageError: fewer than three layers with their maps
std::vector<double> disturbance_of(const ObservedRun& run);

struct TuneCommandOptions {
  std::string run;  ///< empty: the disturbance is `model`
  control::smf_line::DisturbanceModel model;
  std::string algorithm = "slsqp";           ///< slsqp, lbfgs, cobyla
  std::vector<double> start{1.0, 1.0, 0.0};  ///< K_p, K_i*, K_d*
  bool derivative_only = false;              ///< (5.39)
  std::string output;                        ///< picture (SVG); empty = none
  bool json = false;
  bool unsealed = false;  ///< take a run that is not as it was sealed
};
/// @throws UsageError: an unknown algorithm, a start that is not three numbers, a run without layers
int run_tune_smf(const TuneCommandOptions& options);

}  // namespace firn
