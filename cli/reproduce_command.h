// firn reproduce as a study: its parts are computed once, in shards and on other computers as well.
#pragma once

#include <optional>
#include <vector>

#include "cli/study_options.h"
#include "studies/reproduce/reproduce.h"

namespace firn {

struct ReproduceCall {
  ReproduceOptions what;
  StudyOptions study;  ///< results on record are in its folder; none: they are in memory
};

/// Computes the wanted parts in turn, each on all threads.
/// @param code of the program where there are no results
/// @returns none: not all parts are on record yet, or no results were asked for
/// @throws UsageError for an unknown paper or id, with the nearest known one, and as make_study()
std::optional<std::vector<PartResult>> reproduce(const ReproduceCall& call,
                                                 const std::vector<ReproducePart>& parts, int& code);

}  // namespace firn
