// each_message reads the log of a run for an export: every message with its type, or the error that names
// file and byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include "files/record/event_log.h"
#include "lcmtypes/schema.h"

namespace firn::runs {

/// The texts of a run folder.
struct RunTexts {
  std::string experiment_toml, provenance_json;
  std::string result_json;  ///< empty: the run has not ended
};
/// @throws UsageError: no run folder, no log
RunTexts read_texts(const std::filesystem::path& run);

/// Reads the log once, in its order; the memory does not grow with a plain log.
/// @param progress receives the fraction of the log that is read
/// @returns the number of messages
/// @throws std::invalid_argument naming file and byte: damage, a message of unknown type; a log without a
/// message
std::uint64_t each_message(const std::filesystem::path& run,
                           const std::function<void(const record::Event&, const schema::Type&)>& use,
                           const std::function<void(double)>& progress);

/// "RUN/log.lcm: byte 12: HEIGHT_MAP: what"
std::invalid_argument bad_message(const std::filesystem::path& run, const record::Event& event,
                                  const std::string& what);

}  // namespace firn::runs
