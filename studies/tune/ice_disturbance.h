// What an ice print's log says of the disturbance that its feedback worked against [Barnett 2012, (5.16)].
#pragma once

#include <filesystem>
#include <vector>

namespace firn {

/// d_k of each measured interval, in intervals: what the surface rose by on average, less what was commanded,
/// (h_k - h_{k-1}) / dh - (1 + u'_{k-1}), over the judged cells (replay/report_ice_data.h) that both maps
/// know. Before the first map the table counts as flat and u' is 0. Whatever scheme printed it. An interval
/// with a path in doubt ends the list before it.
/// @throws UsageError: no ice run, fewer than three intervals with their maps
std::vector<double> ice_disturbance_of(const std::filesystem::path& run);

}  // namespace firn
