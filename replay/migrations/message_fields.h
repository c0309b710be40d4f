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

namespace firn::replay {

/// Members by path ("header.seq", "drops"), as views into the message.
class MessageFields {
 public:
  /// @throws std::invalid_argument for a message that is damaged or of another type
  MessageFields(const schema::Type& type, std::span<const std::byte> message);

  /// The encoded bytes of a member, of all elements of an array. @returns nothing for a member it has not
  std::optional<std::span<const std::byte>> bytes(std::string_view path) const;
  /// An integer. @throws std::invalid_argument for a path that is none
  std::int64_t integer(std::string_view path) const;
  /// An array of int8_t. @throws std::invalid_argument for a path that is none
  std::vector<std::int8_t> small_integers(std::string_view path) const;
  const schema::Field* field(std::string_view path) const;

 private:
  struct Place {
    const schema::Field* field;
    std::span<const std::byte> bytes;
  };
  std::map<std::string_view, Place> places_;
};

/// Members that a migration gives; the others are taken from the old message by path.
class NewFields {
 public:
  explicit NewFields(const schema::Type& type) : type_(type) {}

  /// @throws std::invalid_argument for a path that is no integer of the type
  void set(std::string_view path, std::int64_t value);
  /// An array of int8_t; the member that counts it is set by set().
  void set(std::string_view path, std::span<const std::int8_t> values);
  /// @throws std::invalid_argument naming a member that neither side has
  std::vector<std::byte> encode(const MessageFields& old) const;

 private:
  const schema::Field& field(std::string_view path) const;
  const schema::Type& type_;
  std::map<std::string, std::vector<std::byte>, std::less<>> given_;
};

}  // namespace firn::replay
