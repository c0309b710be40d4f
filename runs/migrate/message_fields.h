// MessageFields holds a recorded message of a type that has changed, member by member; NewFields computes the
// message's bytes as today's type.
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

namespace firn::runs {

/// Holds members by path ("header.seq", "drops"), as views into the message.
class MessageFields {
 public:
  /// @throws std::invalid_argument for a message that is damaged or of another type
  MessageFields(const schema::Type& type, std::span<const std::byte> message);

  /// Returns the encoded bytes of a member, of all elements of an array; nothing for a member that the
  /// message lacks.
  std::optional<std::span<const std::byte>> bytes(std::string_view path) const;
  /// Returns an integer member. @throws std::invalid_argument if the path is not an integer
  std::int64_t integer(std::string_view path) const;
  /// Returns an array of int8_t. @throws std::invalid_argument if the path is not such an array
  std::vector<std::int8_t> small_integers(std::string_view path) const;
  const schema::Field* field(std::string_view path) const;

 private:
  struct Place {
    const schema::Field* field;
    std::span<const std::byte> bytes;
  };
  std::map<std::string_view, Place> places_;
};

/// Holds the members that a migration sets; the others are copied from the old message by path.
class NewFields {
 public:
  explicit NewFields(const schema::Type& type) : type_(type) {}

  /// @throws std::invalid_argument for a path that is no integer of the type
  void set(std::string_view path, std::int64_t value);
  /// Sets a double. @throws std::invalid_argument for a path that is no double of the type
  void set_number(std::string_view path, double value);
  /// Sets an array of int8_t; the member that counts its elements must be set too.
  void set(std::string_view path, std::span<const std::int8_t> values);
  /// Sets an array without elements; the member that counts them must be set to 0.
  void set_empty(std::string_view path);
  /// Sets a text.
  void set_text(std::string_view path, std::string_view text);
  /// Returns the encoded message.
  /// @throws std::invalid_argument naming a member that neither side has
  std::vector<std::byte> encode(const MessageFields& old) const;

 private:
  const schema::Field& field(std::string_view path) const;
  const schema::Type& type_;
  std::map<std::string, std::vector<std::byte>, std::less<>> given_;
};

}  // namespace firn::runs
