// The state of a study's folder: prints on record and to do, of each scheme and each shard, and the hours,
// bytes and shards that are left.
#pragma once

#include <optional>
#include <string>

#include "studies/compare/study_journal.h"
#include "studies/compare/study_work.h"

namespace firn {

/// Returns the processor time of the prints to do, of each kind by the mean of its prints on record, else as
/// the work says; none where neither is known.
std::optional<double> seconds_left(const StudyWork& work, const StudyJournal& journal,
                                   const StudyShard& shard);

/// Names the file, the number of its lines that do not count and the first of them.
std::string damage_text(const StudyJournal::Damage& damage);

/// @param shard whose prints alone are told; 1 of 1: all
/// @returns lines for people, or one JSON object {prints, on_record, failed, to_do, schemes, hours, bytes,
/// shards_of_60_s}; hours, bytes and shards are of the prints to do, null where no print of a scheme was
/// timed yet
std::string study_state_text(const StudyWork& work, const StudyJournal& journal, const StudyShard& shard);
std::string study_state_json(const StudyWork& work, const StudyJournal& journal, const StudyShard& shard);

}  // namespace firn
