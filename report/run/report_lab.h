// ReportLab holds the functions that read and show the runs of one kind of lab in a report.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "report/run/report_data.h"
#include "runs/read/run_messages.h"

namespace firn::report {

/// Holds a recorded run as a report reads it.
struct RunRecord {
  std::filesystem::path folder;
  const runs::RunMessages& messages;
  std::map<std::string, std::filesystem::path> inputs;  ///< files by role

  bool has(const std::string& role) const { return inputs.contains(role); }
  /// Reads the input of a role. @throws std::invalid_argument: the run has no such input
  std::vector<std::byte> input(const std::string& role) const;
};

struct NamedRun {
  std::string name;
  const RunData* data;
  int style = 0;  ///< of its lines in all charts
};

struct ReportLab {
  /// Fills height, target, mask, truth and the lab's own data. @param rows by layer
  void (*read)(const RunRecord& run, RunData& data, std::map<std::int32_t, LayerRow>& rows);
  /// Returns the HTML behind the error maps, of the runs of this lab that printed one part; nullptr: nothing.
  std::string (*sections)(const std::vector<NamedRun>& runs);
};

/// Droplets: measured surface against target, inks of a print with two; nothing of its own behind the table.
extern const ReportLab kDropletReport;
/// Paths: part as built, error of each interval, RMS against height, speed and frequency along one path.
extern const ReportLab kPathReport;
/// Lines: as droplets, and sections, widths, ends and what was identified along the way.
extern const ReportLab kLineReport;

}  // namespace firn::report
