// The state of a study's folder: prints on record and to do, of each scheme and each shard, and the hours,
// bytes and shards that are left.
#pragma once

#include <optional>
#include <string>

#include "studies/compare/study_journal.h"
#include "studies/compare/study_runner.h"

namespace firn {

/// Returns the processor time of the prints to do, of each scheme by the mean of its prints on record; none
/// where a scheme that has prints to do has none on record.
std::optional<double> seconds_left(const StudyPlan& plan, const StudyJournal& journal,
                                   const StudyShard& shard);

/// @param shard whose prints alone are told; 1 of 1: all
/// @returns lines for people, or one JSON object {prints, on_record, failed, to_do, schemes, hours, bytes,
/// shards_of_60_s}; hours, bytes and shards are of the prints to do, null where no print of a scheme was
/// timed yet
std::string study_state_text(const StudyPlan& plan, const StudyJournal& journal, const StudyShard& shard);
std::string study_state_json(const StudyPlan& plan, const StudyJournal& journal, const StudyShard& shard);

}  // namespace firn
