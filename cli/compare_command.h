// compare prints schemes x parts x seeds in simulated time, or reads runs on record, and computes which
// scheme is better, by how much and with which confidence.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "cli/study_options.h"
#include "studies/compare/study_lab.h"

namespace firn {

struct CompareOptions : StudyOptions {
  std::vector<std::string> words;      ///< of the command line: a study file, or run folders
  std::string study;                   ///< file
  std::string lab;                     ///< file whose lab replaces that of the study's experiment
  std::vector<std::string> overrides;  ///< --set KEY=VALUE for every print, after the study's own
  int seeds = 0;                       ///< > 0: seeds 1..n instead of the study's
  std::string where;                   ///< condition on runs on record in the folders of `words`
  std::string layers;                  ///< "FIRST-LAST": window of runs on record; empty: their last maps
  std::string by;                      ///< "meta.ink": runs on record are grouped by this key, not by scheme
  std::string fail_if;                 ///< "A worse than B": exit code 1 then
};

/// Runs the prints that are not on record yet and writes runs.csv, summary.json, report.html and study.toml
/// into the study folder.
/// @param stop set while it runs: no new print is begun, and kInterrupted is returned.
/// @returns kOk, kFailed where nothing can be compared or `fail_if` holds, or kInterrupted
int compare(const CompareOptions& options, const StudyLab& lab, const std::atomic<bool>* stop);

/// Compares the runs of the command line or of the study file, or else prints the study in the lab of its
/// experiment, stopped by SIGINT and SIGTERM.
int run_compare(const CompareOptions& options);

}  // namespace firn
