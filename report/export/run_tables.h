// export_run computes the tables of one recorded run: every message of its log by topic, its configuration
// and its provenance.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "report/export/tables.h"

namespace firn::report {

/// @param prefix group of the run, "" or "RUN/"
/// @param progress receives the fraction of the log that is read
/// @returns the number of messages
/// @throws UsageError: no run folder, no log; as each_message
std::uint64_t export_run(const std::filesystem::path& run, const std::string& prefix, TableSink& sink,
                         const std::function<void(double)>& progress);

/// Returns the group of a channel: "maps" of HEIGHT_MAP, "events" of FAULT_JET.
std::string_view topic_of(std::string_view channel);

}  // namespace firn::report
