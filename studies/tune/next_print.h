// next_prints computes how much each of some prints would tell about an estimated laboratory: D-optimal
// among inputs that the lab allows [Fedorov 1972, Theory of Optimal Experiments].
#pragma once

#include <string>
#include <vector>

#include "studies/tune/lab_fit.h"

namespace firn::tune {

struct NextPrint {
  std::string name;
  std::string how;           ///< options of firn print: "--set control.scheme=pattern ..."
  double information = 0.0;  ///< decrease of the posterior's entropy [nats]
  std::string narrows;       ///< parameter whose interval shrinks most
  double narrows_to = 1.0;   ///< its standard deviation afterwards over that before
};

struct NextPrintOptions {
  std::uint64_t seed = 1;
  int threads = 1;
  int draws = 20;  ///< of the laboratory, each printed once
  Progress progress = {};
  PrintJournal* journal = nullptr;
};

/// Returns the allowed prints, the most informative one first: the recorded print again; of droplets, random
/// patterns on its part; of ice, the part without feedback and with a lively one.
std::vector<NextPrint> next_prints(const FittedLab& lab, const RecordedRun& run,
                                   const NextPrintOptions& options);

}  // namespace firn::tune
