// MessageTypes finds the types of recorded messages by their fingerprints: Firn's of every version, and those
// of .lcm files that the user names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/schema.h"

namespace firn {

/// Not for several threads: it keeps what it has looked up.
class MessageTypes {
 public:
  /// @param folders each with .lcm files at any depth, or one .lcm file; empty: Firn's types alone
  /// @throws UsageError: a folder that cannot be read or has no .lcm file
  explicit MessageTypes(const std::vector<std::string>& folders = {});
  MessageTypes(const MessageTypes&) = delete;
  MessageTypes& operator=(const MessageTypes&) = delete;

  /// Returns every type that the message may be of; the first one is used. Empty: the type is unknown.
  const std::vector<const schema::Type*>& of(std::span<const std::byte> message) const;
  /// Returns a line for each file or type that could not be read.
  const std::vector<std::string>& problems() const { return problems_; }

  /// A guess at the type of a message with an unknown fingerprint.
  struct Nearest {
    const schema::Type* type = nullptr;  ///< its name is the nearest to the channel's; null: no name is near
    bool fits = false;                   ///< the message has as many bytes as the type's members take
  };
  Nearest nearest_to(std::string_view channel, std::span<const std::byte> message) const;

 private:
  const schema::Type* nearest_name(std::string_view channel) const;

  std::vector<std::string> problems_;  // before others_, whose reading fills it
  Schema others_;
  mutable std::map<std::int64_t, std::vector<const schema::Type*>> known_;  // by fingerprint, as met
  mutable std::map<std::string, const schema::Type*, std::less<>> near_;    // by channel, as met
};

/// "firn.header_t"
std::string full_name(const schema::Type& type);

/// Says why bytes are no LCM message: "LCM's self test", "5 bytes, no fingerprint", "text". Nothing where
/// they may be one.
std::optional<std::string> not_lcm(std::string_view channel, std::span<const std::byte> message);

}  // namespace firn
