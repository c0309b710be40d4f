// event_line and record_line write one event or record as `firn log cat` prints it: a JSON object on one
// line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "files/record/event_log.h"
#include "files/record/record_file.h"
#include "lcmtypes/schema.h"

namespace firn {

class MessageTypes;

struct LineOptions : JsonOptions {
  const MessageTypes* types = nullptr;  ///< null: Firn's
};

/// The line of a message of unknown type has "unknown_fingerprint" and the type with the nearest name; that
/// of other bytes says "not_lcm".
std::string event_line(const record::Event& event, const LineOptions& options);

/// A record in readable form.
struct RecordLine {
  std::string json;
  std::string error;                   ///< of a payload that cannot be decoded
  std::optional<std::int64_t> now_us;  ///< of an event; other records belong to the event before
  std::vector<std::string> channels;   ///< that it is about
};
/// @param write_ahead whether the kinds are those of runtime/write_ahead.h; else only kind and size are known
RecordLine record_line(const record::Record& record, bool write_ahead, const LineOptions& options);

}  // namespace firn
