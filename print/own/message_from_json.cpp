#include "print/own/message_from_json.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <string>

#include "files/json.h"

namespace firn {

using schema::Kind;

namespace {

using Json = nlohmann::json;

constexpr std::string_view kHeader = "header.";

[[noreturn]] void refuse(const std::string& member, const std::string& why) {
  throw std::invalid_argument(member + ": " + why);
}

class Encoder {
 public:
  Encoder(const schema::Type& type, const Json& object, std::span<const std::string_view> optional)
      : type_(type), object_(object), optional_(optional) {}

  std::vector<std::byte> encode() {
    for (const auto& [name, _] : object_.items()) know(name);
    count();
    put(std::uint64_t(type_.fingerprint), 8);
    for (const schema::Field& f : type_.fields) field(f);
    return std::move(out_);
  }

 private:
  void know(const std::string& name) const {
    std::string known;
    for (const schema::Member& m : type_.members) {
      if (m.name == name) return;
      known += (known.empty() ? "" : ", ") + m.name;
    }
    refuse(name, type_.name + " has no such member; it has " + known);
  }

  const Json* find(const std::string& path) const {
    const Json* at = &object_;
    for (std::size_t from = 0;;) {
      const std::size_t dot = path.find('.', from);
      if (!at->is_object()) return nullptr;
      const auto found = at->find(path.substr(from, dot - from));
      if (found == at->end()) return nullptr;
      at = &*found;
      if (dot == path.npos) return at;
      from = dot + 1;
    }
  }

  // Arrays tell how many elements they have; a counter that is given must agree.
  void count() {
    std::map<int, std::string> counted_by;
    for (const schema::Field& f : type_.fields) {
      if (f.dimensions.empty()) continue;
      if (f.dimensions.size() > 1 || f.kind == Kind::kStruct)
        refuse(f.path, "arrays of arrays and of messages cannot be given as JSON");
      const Json* const v = find(f.path);
      if (!v || !v->is_array()) refuse(f.path, v ? "must be an array" : "is missing");
      const schema::Dimension& d = f.dimensions[0];
      if (!d.variable) {
        if (v->size() != std::size_t(d.size))
          refuse(f.path, "has " + std::to_string(v->size()) + " elements, not " + std::to_string(d.size));
        continue;
      }
      const auto [at, is_first] = sizes_.try_emplace(d.slot, v->size());
      if (!is_first && at->second != v->size())
        refuse(f.path, "has " + std::to_string(v->size()) + " elements, " + counted_by[d.slot] + " has " +
                           std::to_string(at->second));
      counted_by[d.slot] = f.path;
    }
    for (const schema::Field& f : type_.fields)
      if (const auto size = sizes_.find(f.slot); f.slot >= 0 && size != sizes_.end())
        if (const Json* const v = find(f.path); v && *v != Json(size->second))
          refuse(f.path, v->dump() + " is not the " + std::to_string(size->second) + " elements of " +
                             counted_by[f.slot]);
  }

  void field(const schema::Field& f) {
    if (const auto size = sizes_.find(f.slot); f.slot >= 0 && size != sizes_.end())
      return integer(f, Json(size->second));
    const Json* const v = find(f.path);
    if (!v && f.path.starts_with(kHeader)) return put(0, schema::size_of(f.kind));
    if (!v && f.kind == Kind::kString && std::ranges::find(optional_, f.path) != optional_.end())
      return text(f, "");
    if (!v) refuse(f.path, "is missing");
    if (f.dimensions.empty()) return value(f, *v);
    for (const Json& element : *v) value(f, element);
  }

  void value(const schema::Field& f, const Json& v) {
    if (f.kind == Kind::kString) return text(f, v);
    if (f.kind == Kind::kFloat || f.kind == Kind::kDouble) return real(f, v);
    integer(f, v);
  }

  void text(const schema::Field& f, const Json& v) {
    if (!v.is_string()) refuse(f.path, v.dump() + " is no text");
    const std::string& s = v.get_ref<const std::string&>();
    if (s.find('\0') != s.npos) refuse(f.path, "a text holds no NUL");
    put(s.size() + 1, 4);
    for (const char c : s) out_.push_back(std::byte(c));
    out_.push_back(std::byte{0});
  }

  void real(const schema::Field& f, const Json& v) {
    if (!v.is_number() && !v.is_null()) refuse(f.path, v.dump() + " is no number");
    const double x = v.is_null() ? std::numeric_limits<double>::quiet_NaN() : v.get<double>();
    if (f.kind == Kind::kDouble) return put(std::bit_cast<std::uint64_t>(x), 8);
    if (std::abs(x) > double(std::numeric_limits<float>::max()))
      refuse(f.path, v.dump() + " is more than a float holds");
    put(std::bit_cast<std::uint32_t>(float(x)), 4);
  }

  void integer(const schema::Field& f, const Json& v) {
    if (f.kind == Kind::kBoolean && v.is_boolean()) return put(v.get<bool>(), 1);
    const bool above = v.is_number_unsigned() &&
                       v.get<std::uint64_t>() > std::uint64_t(std::numeric_limits<std::int64_t>::max());
    if (!v.is_number_integer() || above) refuse(f.path, v.dump() + " is no whole number of 64 bits");
    const std::int64_t n = v.get<std::int64_t>();
    const std::size_t bytes = schema::size_of(f.kind);
    const bool is_unsigned = f.kind == Kind::kByte || f.kind == Kind::kBoolean;
    const std::int64_t most = f.kind == Kind::kBoolean ? 1
                              : is_unsigned            ? 255
                                            : std::numeric_limits<std::int64_t>::max() >> (64 - 8 * bytes);
    const std::int64_t least = is_unsigned ? 0 : -most - 1;
    if (n < least || n > most)
      refuse(f.path, v.dump() + " is outside " + std::to_string(least) + " to " + std::to_string(most));
    put(std::uint64_t(n), bytes);
  }

  void put(std::uint64_t v, std::size_t bytes) {
    for (std::size_t k = bytes; k-- > 0;) out_.push_back(std::byte(v >> (8 * k)));
  }

  const schema::Type& type_;
  const Json& object_;
  std::span<const std::string_view> optional_;
  std::map<int, std::size_t> sizes_;  // elements by the slot that counts them
  std::vector<std::byte> out_;
};

}  // namespace

std::vector<std::byte> message_from_json(const schema::Type& type, std::string_view json,
                                         std::initializer_list<std::string_view> optional) {
  Json object;
  try {
    object = Json::parse(std::string(json));
  } catch (const Json::parse_error& e) {
    throw std::invalid_argument("no JSON: byte " + std::to_string(e.byte) + " is not as JSON wants it");
  }
  if (!object.is_object()) throw std::invalid_argument("no JSON object: {\"member\": value, ...} is wanted");
  return Encoder(type, object, {optional.begin(), optional.size()}).encode();
}

}  // namespace firn
