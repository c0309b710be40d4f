#include "runs/migrate/message_fields.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "lcmtypes/schema_walk.h"

namespace firn::runs {
namespace {

void append_integer(std::vector<std::byte>& to, std::int64_t value, std::size_t size) {
  for (std::size_t k = size; k-- > 0;) to.push_back(std::byte(std::uint64_t(value) >> (8 * k)));
}

bool is_integer(schema::Kind kind) { return kind <= schema::Kind::kBoolean; }

// Returns true if the encoded bytes of one mean the same in the other.
bool alike(const schema::Field& a, const schema::Field& b) {
  return a.kind == b.kind && a.element == nullptr && b.element == nullptr &&
         std::ranges::equal(a.dimensions, b.dimensions, [](const auto& x, const auto& y) {
           return x.variable == y.variable && x.size == y.size;
         });
}

}  // namespace

MessageFields::MessageFields(const schema::Type& type, std::span<const std::byte> message) {
  std::vector<FieldPlace> found(type.fields.size());
  if (const auto error = check(type, message, found))
    throw std::invalid_argument(type.name + ", byte " + std::to_string(error->offset) + ": " +
                                error->message);
  for (std::size_t n = 0; n < found.size(); ++n) {
    const std::size_t from = found[n].offset,
                      to = n + 1 < found.size() ? found[n + 1].offset : message.size();
    places_.emplace(type.fields[n].path, Place{&type.fields[n], message.subspan(from, to - from)});
  }
}

std::optional<std::span<const std::byte>> MessageFields::bytes(std::string_view path) const {
  const auto it = places_.find(path);
  return it == places_.end() ? std::nullopt : std::optional(it->second.bytes);
}

const schema::Field* MessageFields::field(std::string_view path) const {
  const auto it = places_.find(path);
  return it == places_.end() ? nullptr : it->second.field;
}

std::int64_t MessageFields::integer(std::string_view path) const {
  const auto it = places_.find(path);
  if (it == places_.end() || !is_integer(it->second.field->kind) || !it->second.field->dimensions.empty())
    throw std::invalid_argument("the old message has no integer " + std::string(path));
  return schema::integer_at(it->second.field->kind, it->second.bytes.data());
}

std::vector<std::int8_t> MessageFields::small_integers(std::string_view path) const {
  const auto it = places_.find(path);
  if (it == places_.end() || it->second.field->kind != schema::Kind::kInt8)
    throw std::invalid_argument("the old message has no int8_t " + std::string(path));
  std::vector<std::int8_t> values;
  values.reserve(it->second.bytes.size());
  for (const std::byte b : it->second.bytes) values.push_back(std::int8_t(b));
  return values;
}

const schema::Field& NewFields::field(std::string_view path) const {
  const auto it = std::ranges::find(type_.fields, path, &schema::Field::path);
  if (it == type_.fields.end())
    throw std::invalid_argument(type_.name + " has no member " + std::string(path));
  return *it;
}

void NewFields::set(std::string_view path, std::int64_t value) {
  const schema::Field& f = field(path);
  if (!is_integer(f.kind) || !f.dimensions.empty())
    throw std::invalid_argument(type_.name + "." + f.path + " is no integer");
  std::vector<std::byte> bytes;
  append_integer(bytes, value, schema::size_of(f.kind));
  given_.insert_or_assign(f.path, std::move(bytes));
}

void NewFields::set_number(std::string_view path, double value) {
  const schema::Field& f = field(path);
  if (f.kind != schema::Kind::kDouble || !f.dimensions.empty())
    throw std::invalid_argument(type_.name + "." + f.path + " is no double");
  std::vector<std::byte> bytes;
  append_integer(bytes, std::bit_cast<std::int64_t>(value), sizeof value);
  given_.insert_or_assign(f.path, std::move(bytes));
}

void NewFields::set(std::string_view path, std::span<const std::int8_t> values) {
  const schema::Field& f = field(path);
  if (f.kind != schema::Kind::kInt8 || f.dimensions.size() != 1)
    throw std::invalid_argument(type_.name + "." + f.path + " is no array of int8_t");
  const auto bytes = std::as_bytes(values);
  given_.insert_or_assign(f.path, std::vector<std::byte>(bytes.begin(), bytes.end()));
}

void NewFields::set_text(std::string_view path, std::string_view text) {
  const schema::Field& f = field(path);
  if (f.kind != schema::Kind::kString || !f.dimensions.empty())
    throw std::invalid_argument(type_.name + "." + f.path + " is no text");
  std::vector<std::byte> bytes;
  append_integer(bytes, std::int64_t(text.size()) + 1, 4);
  for (const char c : text) bytes.push_back(std::byte(c));
  bytes.push_back(std::byte(0));
  given_.insert_or_assign(f.path, std::move(bytes));
}

void NewFields::set_empty(std::string_view path) {
  if (field(path).dimensions.empty())
    throw std::invalid_argument(type_.name + "." + std::string(path) + " is no array");
  given_[std::string(path)] = {};
}

std::vector<std::byte> NewFields::encode(const MessageFields& old) const {
  std::vector<std::byte> message;
  append_integer(message, type_.fingerprint, 8);
  for (const schema::Field& f : type_.fields) {
    if (const auto it = given_.find(f.path); it != given_.end()) {
      message.insert(message.end(), it->second.begin(), it->second.end());
      continue;
    }
    const schema::Field* was = old.field(f.path);
    if (!was || !alike(*was, f))
      throw std::invalid_argument(type_.name + "." + f.path + " is new, and its migration does not give it");
    const auto bytes = *old.bytes(f.path);
    message.insert(message.end(), bytes.begin(), bytes.end());
  }
  return message;
}

}  // namespace firn::runs
