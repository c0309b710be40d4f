// write_report writes one self-contained page for any number of runs.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct Product;

struct ReportOptions {
  std::vector<std::string> runs;  ///< run folders
  std::string output = "report.html";
  std::vector<std::string> verdicts;  ///< of replay, by run; empty = each run is replayed for the report
  bool no_replay =
      false;  ///< no verdict then: a long run is replayed for minutes, its figures read in seconds
  bool unsealed = false;  ///< show runs that are not as they were sealed, marked
  bool json = false;
};

/// Writes the page whole or not at all, and metrics.csv into each run folder. @throws UsageError,
/// std::runtime_error
void write_report(const Product& product, const ReportOptions& options);

/// @returns 0 written, 2 usage
int run_report(const Product& product, const ReportOptions& options);

}  // namespace firn
