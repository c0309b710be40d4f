// ice_disturbance_of computes from an ice print's log the disturbance against which its feedback worked
// [Barnett 2012, (5.16)].
#pragma once

#include <filesystem>
#include <vector>

namespace firn {

/// Returns d_k of each measured interval, in intervals: the mean rise of the surface less the commanded rise,
/// (h_k - h_{k-1}) / dh - (1 + u'_{k-1}), over the judged cells (replay/ice_error.h) known to both
/// maps. Before the first map the table counts as flat and u' is 0. Any scheme may have printed it. An
/// interval with a path in doubt ends the list before it.
/// @throws UsageError: no ice run, fewer than three intervals with their maps
std::vector<double> ice_disturbance_of(const std::filesystem::path& run);

}  // namespace firn
