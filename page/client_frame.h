// ClientFrame holds one text frame that a browser sends.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "page/map_frame.h"

namespace firn::page {

struct ClientFrame {
  enum class Kind { kFollow, kCommand, kPing };
  Kind kind = Kind::kPing;
  std::int64_t id = 0;             ///< of the command or ping
  std::optional<Surface> surface;  ///< kFollow; nothing: no more maps
  std::optional<int> layer;        ///< kFollow: that layer once; nothing: the newest and each new one
  std::string token;               ///< kCommand
  std::vector<std::string> words;  ///< kCommand: as of firn ctl, {"pause"}, {"set", "KEY=VALUE"}
};

inline constexpr std::size_t kMaxFrameBytes = 4096;

/// @throws std::invalid_argument naming the member and its requirement
ClientFrame parse_client_frame(std::string_view text);

/// Returns the member "token" of a browser's request; empty: it has none. @throws std::invalid_argument
std::string parse_token(std::string_view text);

struct Notes {
  std::vector<std::string> tags;
  std::string note;
};
inline constexpr std::size_t kMaxNotesBytes = 16384;
inline constexpr std::size_t kMaxTags = 32;
inline constexpr std::size_t kMaxTagBytes = 64;

/// Reads {"token", "tags", "note"} of a browser, or RUN/notes.json, which has no token and line breaks.
/// @param token receives the token; nullptr: none is wanted
/// @throws std::invalid_argument naming the member and its limit
Notes parse_notes(std::string_view text, std::string* token);
std::string to_json(const Notes& notes);

/// Returns true if the two texts are equal; takes the same time wherever they differ.
bool same_secret(std::string_view a, std::string_view b);

}  // namespace firn::page
