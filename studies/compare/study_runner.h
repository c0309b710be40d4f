// run_study makes the prints of a study that are not on record yet, on several threads.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "config/study.h"
#include "report/run/report_page.h"
#include "studies/compare/study_journal.h"

namespace firn {

/// Holds a study with all its experiments resolved and checked.
struct StudyPlan {
  Study study;
  const StudyLab* lab = nullptr;
  std::vector<Experiment> experiments;               ///< [arm * parts + part], without seed and lab of a seed
  std::vector<std::shared_ptr<const Blobs>> inputs;  ///< likewise; equal ones are one object
  std::vector<StudyCell> cells;      ///< seed by seed, so that the finished cells are always balanced
  std::vector<std::size_t> metrics;  ///< of the lab, the study's primary one first

  std::size_t at(std::size_t arm, std::size_t part) const { return arm * study.parts.size() + part; }
  /// Returns the experiment of one print: its seed and the lab of the seed are set.
  Experiment experiment(const StudyCell& cell) const;
};

/// @param folder of the study file. @throws ConfigError, UsageError naming file, key and limit
StudyPlan plan_study(Study study, const std::filesystem::path& folder, const StudyLab& lab,
                     const std::string& study_file);

/// A share of a study's prints: number `number`, from 1, of `of`.
struct StudyShard {
  int number = 1, of = 1;
};

struct StudyRunOptions {
  int threads = 0;                          ///< 0 = as many as the machine has
  StudyShard shard = {};                    ///< prints these alone
  std::size_t most = 0;                     ///< prints; 0 = all
  bool first_of_each = false;               ///< one print of each scheme that has none on record
  bool again = false;                       ///< prints on record that stopped before their end, and no others
  const std::atomic<bool>* stop = nullptr;  ///< set: no new print is begun
  std::function<void(std::size_t done, std::size_t failed)> progress;  ///< of the prints that were to do
};

struct StudyRunSummary {
  std::size_t to_do = 0, done = 0;
  double cpu_s = 0.0;  ///< of the prints made now
};

/// Returns the prints that run_study() would make, in the order of the plan.
std::vector<const StudyCell*> prints_to_do(const StudyPlan& plan, const StudyJournal& journal,
                                           const StudyRunOptions& options);

/// @throws the journal's exceptions; a print that fails is a result.
StudyRunSummary run_study(const StudyPlan& plan, StudyJournal& journal, const StudyRunOptions& options);

/// Returns the table to analyse. @pre every cell is on record
report::StudyTable study_table(const StudyPlan& plan, const StudyJournal& journal);

/// Returns settings that differ between the arms on the first part, or between the parts under the first arm.
std::vector<report::DifferingParameter> differing_arms(const StudyPlan& plan);
std::vector<report::DifferingParameter> differing_parts(const StudyPlan& plan);

}  // namespace firn
