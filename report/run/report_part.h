// Draws what the runs of one part share in a report: error maps, surfaces, sections, charts by layer. Runs of
// different parts share no axis.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_lab.h"

namespace firn::replay {

/// Holds the runs of one part.
struct PartRuns {
  std::string title;  ///< name of the experiment and size
  std::vector<NamedRun> runs;
};

/// Parts the runs by PartIdentity, in the order in which the parts first occur.
std::vector<PartRuns> parts_of(const std::vector<NamedRun>& runs);

/// Returns the HTML: error maps first.
std::string part_sections(const std::vector<NamedRun>& runs);

}  // namespace firn::replay
