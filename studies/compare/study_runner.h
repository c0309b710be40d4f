// StudyPlan is a comparison as work for the engine of studies, and its results as a table.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "config/study.h"
#include "report/run/report_page.h"
#include "studies/compare/study_work.h"

namespace firn {

/// Holds a study with all its experiments resolved and checked.
class StudyPlan : public StudyWork {
 public:
  Study study;
  const StudyLab* lab = nullptr;
  std::vector<Experiment> experiments;               ///< [arm * parts + part], without seed and lab of a seed
  std::vector<std::shared_ptr<const Blobs>> inputs;  ///< likewise; equal ones are one object
  std::vector<std::size_t> metrics;                  ///< of the lab, the study's primary one first
  bool edge_bound = false;                           ///< it is one of them

  std::size_t at(std::size_t arm, std::size_t part) const { return arm * study.parts.size() + part; }
  /// Returns the experiment of one print: its seed and the lab of the seed are set.
  Experiment experiment(const StudyCell& cell) const;
  StudyPrint make(const StudyCell& cell) const override;
};

/// Returns the digest of all that decides a print, but for the program and the platform.
/// @param inputs of a print that is planned have no digest yet: their bytes count
std::string digest_of(const Experiment& experiment, const Blobs& inputs);

/// @param folder of the study file. @throws ConfigError, UsageError naming file, key and limit
StudyPlan plan_study(Study study, const std::filesystem::path& folder, const StudyLab& lab,
                     const std::string& study_file);

/// Returns the table to analyse. @pre every cell is on record
report::StudyTable study_table(const StudyPlan& plan, const StudyJournal& journal);

/// Returns settings that differ between the arms on the first part, or between the parts under the first arm.
std::vector<report::DifferingParameter> differing_arms(const StudyPlan& plan);
std::vector<report::DifferingParameter> differing_parts(const StudyPlan& plan);

}  // namespace firn
