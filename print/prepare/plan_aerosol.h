// Plans a print job on an aerosol machine (firn plan): computes the stage's trajectory and the shutter's
// commands.
#pragma once

#include <string>

#include "config/aerosol_lab.h"
#include "core/motion/aerosol/plan.h"

namespace firn {

struct AerosolPlanOptions {
  std::string job;              ///< *.json or *.csv, files/path/print_job_file.h
  std::string corner = "loop";  ///< paper, loop or hybrid
  double tolerance_mm = 0.05;   ///< of hybrid
  Point2 origin_mm;             ///< added to the job's coordinates
  std::string trajectory;       ///< the stage's samples, docs/formats.md; empty: no file
  std::string csv, plot;        ///< files; empty: no file
  bool json = false;
};

/// Prints the report of all three ways of turning corners, the chosen one marked; writes the files of the
/// chosen one.
/// @returns 0; 1 when segments are refused (each is named with its reason, nothing is written). @throws
/// UsageError
int run_plan_aerosol(const Machine& machine, const AerosolPlanOptions& options);

}  // namespace firn
