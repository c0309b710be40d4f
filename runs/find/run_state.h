// Tells whether a run folder is as it was, by the times and sizes of few of its files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace firn::runs {

/// Calls `use` with the name and the state of each folder in a place that may be a run (is_run tells); the
/// state is another number once one of its documents, its notes or its records was written, renamed or
/// packed.
/// @throws UsageError: no such folder
void each_run_state(const std::filesystem::path& place,
                    const std::function<void(const std::string& name, std::int64_t state)>& use);

/// Returns the state of one folder.
std::int64_t run_state(const std::filesystem::path& run);

}  // namespace firn::runs
