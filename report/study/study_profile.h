// Computes the profile of an error along a print, e.g. the RMS against the height [Barnett 2012, Fig. 5-9],
// of all schemes of a study.
#pragma once

#include <string>
#include <vector>

#include "report/study/study_analysis.h"

namespace firn::report {

/// Holds the statistics of one scheme on one part, at one place along the print, over all seeds that reached
/// it (also those that stopped later).
struct ProfileRow {
  std::size_t arm = 0, part = 0;
  double x = 0.0;
  std::size_t seeds = 0;
  double mean = 0.0;
  statistics::Interval interval;  ///< 95 % of the mean, BCa over seeds
  double least = 0.0, largest = 0.0;
};

/// Returns the rows part by part, arm by arm, x ascending; empty for studies without profiles.
std::vector<ProfileRow> profile_rows(const StudyTable& table);

std::string profile_csv(const StudyTable& table, const std::vector<ProfileRow>& rows);
/// Returns text for the terminal: a line for each x, a column for each scheme.
std::string profile_text(const StudyTable& table, const std::vector<ProfileRow>& rows);
/// Returns HTML: a chart for each part, mean and its interval; "" for no rows.
std::string profile_section(const StudyTable& table, const std::vector<ProfileRow>& rows);

}  // namespace firn::report
