// Draws what the runs of one part share in a report: error maps, surfaces, sections, charts by layer. Runs of
// different parts share no axis.
#pragma once

#include <string>
#include <vector>

#include "report/run/report_lab.h"

namespace firn::report {

/// Holds the runs of one part.
struct PartRuns {
  std::string title;  ///< name of the experiment and size
  std::vector<NamedRun> runs;
};

/// Parts the runs by PartIdentity, in the order in which the parts first occur.
std::vector<PartRuns> parts_of(const std::vector<NamedRun>& runs);

/// Returns "cylinder, 10.0 × 10.0 × 0.40 mm".
std::string part_title(const PartIdentity& part);

/// Returns the HTML: error maps first; of one run with its section and its curve beside the map.
std::string part_sections(const std::vector<NamedRun>& runs);

}  // namespace firn::report
