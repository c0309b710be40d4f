// Foxglove's well-known messages of a run's messages: maps as foxglove.Grid, which a 3D panel draws, and what
// happened as foxglove.Log. Schemas: https://docs.foxglove.dev/docs/sdk/schemas
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "lcmtypes/schema.h"

namespace firn::report {

inline constexpr std::string_view kFoxgloveGrid = "foxglove.Grid", kFoxgloveLog = "foxglove.Log";

/// Returns the JSON schema of one of the two.
std::string foxglove_schema(std::string_view name);

/// Returns the maps of a checked message as the JSON of a foxglove.Grid, every map a field of a cell, lengths
/// in mm, in the frame "part"; nothing of a message without a grid or without a map on it.
/// @param places of the message's fields, as check() fills them
/// @param time_ns since the start of the run
std::optional<std::string> foxglove_grid(const schema::Type& type, std::span<const std::byte> message,
                                         std::span<const FieldPlace> places, std::uint64_t time_ns);

/// A line of a log.
struct FoxgloveLog {
  int level = 2;     ///< foxglove.LogLevel: 2 information, 3 warning, 4 error
  std::string name;  ///< who says it
  std::string text;

  bool operator==(const FoxgloveLog&) const = default;
};

/// Returns a fault, a safe stop, an order of the operator, or a start or end of the run as a line of a log;
/// nothing of any other message.
std::optional<FoxgloveLog> foxglove_log(const schema::Type& type, std::span<const std::byte> message);
/// Returns the JSON of a foxglove.Log.
std::string log_json(const FoxgloveLog& log, std::uint64_t time_ns);

}  // namespace firn::report
