// Trial files are unfinished files of a run folder, whose names no seal counts and no reader opens.
#pragma once

#include <filesystem>
#include <string>

namespace firn::runs {

/// Returns true for the name of a file that becomes another one by a rename when it is whole:
/// "nodes/stage.wal.part" of a packing or an expansion, "log.lcm.repairing" of a repair, "world/state.new" of
/// the world. Firn 0.1 packed to "nodes/stage.wal.packed".
bool is_trial_file(const std::string& path);

/// Removes the trial files among the records: a kill left them. The caller holds the lock of the run, and
/// files of other users stay.
void remove_trial_files(const std::filesystem::path& run);

/// Refuses a run folder with a link, a pipe or a device among its files, before anything is written there.
/// The folder of the instruments, RUN/io, may have links.
/// @throws UsageError naming the file
void refuse_links(const std::filesystem::path& run);

}  // namespace firn::runs
