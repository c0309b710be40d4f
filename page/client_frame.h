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

/// Additions that a browser makes to a run's notes.
struct NoteRequest {
  std::string token;
  std::string author;                 ///< empty: the user of the process
  std::string note;                   ///< empty: none
  std::vector<std::string> add_tags;  ///< tags to set
  std::vector<std::string> remove_tags;
};
inline constexpr std::size_t kMaxNotesBytes = 16384;
inline constexpr std::size_t kMaxTagsOfRequest = 32;
inline constexpr std::size_t kMaxTagBytesOfRequest = 64;

/// Reads {"token", "author", "note", "add_tags", "remove_tags"}, all but the token optional.
/// @throws std::invalid_argument naming the member and its limit
NoteRequest parse_note_request(std::string_view text);

/// The acknowledgement of an alarm, by a browser.
struct AckRequest {
  std::string token;
  std::string author;  ///< empty: whoever the token is of
  std::string alarm;   ///< page/alarms.h
};
/// Reads {"token", "author", "alarm"}. @throws std::invalid_argument naming the member and its limit
AckRequest parse_ack_request(std::string_view text);

/// Returns true if the two texts are equal; takes the same time wherever they differ.
bool same_secret(std::string_view a, std::string_view b);

}  // namespace firn::page
