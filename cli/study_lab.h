// All that `firn compare` knows of a lab: what it measures, what a seed is, and how to print once. A study of another
// lab needs another of these, and nothing else.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "replay/study_analysis.h"
#include "runtime/node.h"

namespace firn {

/// One print. Metrics in the lab's order; NaN where the print left nothing to measure.
struct StudyPrint {
  bool finished = false;
  std::string outcome, reason;
  std::vector<double> metrics;
  double cpu_s = 0.0;  ///< differs from run to run
};

struct StudyLab {
  std::vector<replay::StudyMetric> metrics;   ///< smaller is better in each; the first is primary unless a study says else
  std::vector<std::string> usual;             ///< metrics of a study that names none
  void (*set_seed)(Experiment&, std::uint64_t seed);
  void (*check)(const Experiment&);           ///< throws where this lab cannot print the experiment
  StudyPrint (*print)(const Experiment&, const Blobs& inputs);  ///< thread-safe; throws nothing but std::bad_alloc
};

/// Lu's ink-jet lab in simulated time; metrics are of the true surface.
const StudyLab& inkjet_study_lab();

}  // namespace firn
