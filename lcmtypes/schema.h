// Reflection over LCM types at run time, read from the .lcm texts: sizes and bounds before a decode, leaves
// by path, the first difference of two messages, JSON. LCM's own decoders resize arrays to whatever the bytes
// claim; nothing here allocates in proportion to a claimed size. Encoding:
// https://lcm-proj.github.io/lcm/content/lcm-type-ref.html (fingerprint, then big-endian members).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace firn {

/// All .lcm files of the house, one after another; logs and write-ahead files carry them to explain
/// themselves.
std::string_view lcm_type_texts();

namespace schema {

enum class Kind : std::uint8_t {
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kByte,
  kBoolean,
  kFloat,
  kDouble,
  kString,
  kStruct
};
/// Encoded bytes of a number; 0 for strings and structs.
std::size_t size_of(Kind kind);

struct Dimension {
  bool variable = false;
  std::int32_t size = 0;  ///< fixed
  int slot = -1;          ///< variable: which of the type's counting members
  std::string text;       ///< as in the .lcm text: a number, also of a constant, or the member's name
};
inline constexpr std::size_t kMaxDimensions = 8;
inline constexpr std::size_t kMaxSlots = 64;
inline constexpr int kMaxDepth = 500;  ///< of messages in messages: a type may hold arrays of itself

struct Type;

/// One member with structs that stand alone resolved: "header.seq". Arrays of structs stay one field.
struct Field {
  std::string path;
  Kind kind = Kind::kInt8;
  std::vector<Dimension> dimensions;  ///< empty = one value
  int slot = -1;                      ///< this integer counts arrays
  const Type* element = nullptr;      ///< kStruct
};

/// One member as written.
struct Member {
  std::string name;
  std::string type;
  Kind kind = Kind::kInt8;
  std::vector<Dimension> dimensions;
};

struct Type {
  std::string package, name;
  bool enumeration = false;  ///< one int32_t, "value"
  std::vector<Member> members;
  std::vector<Field> fields;
  std::size_t slots = 0;           ///< counting members
  std::size_t smallest_bytes = 0;  ///< of an encoded value without fingerprint
  std::uint64_t struct_hash = 0;
  std::int64_t fingerprint = 0;
  std::string origin;  ///< "types/pose_t.lcm:3"; empty: of the house
};

}  // namespace schema

/// One .lcm file.
struct TypeFile {
  std::string name, text;
};

/// An error of the size or the form of an encoded message.
struct SizeError {
  std::size_t offset = 0;  ///< byte in the message
  std::string path;        ///< member, or empty
  std::string message;
};

using LeafValue = std::variant<std::int64_t, double, std::string_view>;

struct Leaf {
  std::string_view path;  ///< "header.seq", "height_mm[17]"; valid during the call
  schema::Kind kind{};
  std::size_t offset = 0;
  std::size_t bytes = 0;
  LeafValue value;
};
/// "-3", "0.1", "nan (0x7fc00000)", "\"text\"": enough to tell two values apart.
std::string to_text(const Leaf& leaf);

struct FieldDifference {
  std::string path;  ///< "(fingerprint)" and "(length)" for differences outside the members
  std::string a, b;  ///< texts of the values; "(missing)" where a message ends before
  std::size_t offset = 0;
};

struct JsonOptions {
  std::size_t array_limit = 16;  ///< longer arrays become {"count": n, "first": [8 values]}
  bool full = false;             ///< no limit
};

class Schema {
 public:
  /// Of lcm_type_texts(), parsed once.
  static const Schema& builtin();
  /// @throws std::invalid_argument with line and cause: syntax, unknown type, a type that holds itself
  /// without a counted array between, more than kMaxDimensions dimensions
  static Schema parse(std::string_view texts);
  /// Reads .lcm files of others. A file or type that cannot be read is left out; so is a second type of one
  /// name.
  /// @param problems receives a line for each of these
  static Schema parse_files(std::span<const TypeFile> files, std::vector<std::string>& problems);

  /// By "height_map_t" or "firn.height_map_t". @returns nullptr if unknown.
  const schema::Type* find(std::string_view name) const;
  const schema::Type* find_fingerprint(std::int64_t fingerprint) const;
  /// The type whose fingerprint an encoded message begins with. @returns nullptr if unknown or shorter than 8
  /// bytes.
  const schema::Type* type_of(std::span<const std::byte> message) const;
  const std::deque<schema::Type>& types() const { return types_; }
  /// Returns the types without those that parse_files() could not read, in the order of the texts.
  const std::vector<const schema::Type*>& readable() const { return readable_; }
  /// Returns every type with the fingerprint: types of different names may share one.
  std::vector<const schema::Type*> all_of(std::int64_t fingerprint) const;

  Schema(Schema&&) = default;  // the types point at each other
  Schema(const Schema&) = delete;
  Schema& operator=(const Schema&) = delete;

 private:
  Schema() = default;
  void keep(const schema::Type& type);

  std::deque<schema::Type> types_;
  std::vector<const schema::Type*> readable_;
  std::map<std::string, const schema::Type*, std::less<>> by_name_;
  std::map<std::int64_t, const schema::Type*> by_fingerprint_;
};

/// Would LCM decode exactly these bytes, with every count, string and array inside them? Trailing bytes are
/// an error. Arrays of numbers cost O(1).
std::optional<SizeError> check(const schema::Type& type, std::span<const std::byte> message);

/// The same of the bytes behind the fingerprint, whatever that is.
std::optional<SizeError> check_members(const schema::Type& type, std::span<const std::byte> message);

/// Where a field of a checked message stands.
struct FieldPlace {
  std::size_t offset;  ///< strings: of the length
  std::size_t count;   ///< elements; 1 for a single value
};
/// As check(), and fills places[i] for type.fields[i]; places.size() >= type.fields.size().
std::optional<SizeError> check(const schema::Type& type, std::span<const std::byte> message,
                               std::span<FieldPlace> places);

/// Calls `visit` for every number and string in encoded order until it returns false.
/// @returns the damage that stopped the walk, if there is one (leaves before it were visited).
std::optional<SizeError> for_each_leaf(const schema::Type& type, std::span<const std::byte> message,
                                       const std::function<bool(const Leaf&)>& visit);

/// The leaf in which two messages first differ; nothing if their bytes are equal. Takes damaged messages.
std::optional<FieldDifference> first_difference(const schema::Type& type, std::span<const std::byte> a,
                                                std::span<const std::byte> b);

/// One JSON object, no spaces; NaN and infinities are null, "Infinity", "-Infinity". A damaged message gets
/// the members before the damage and "_error".
std::string to_json(const schema::Type& type, std::span<const std::byte> message,
                    const JsonOptions& options = {});

/// `text` as a JSON string with its quotes; bytes that are not UTF-8 become U+FFFD.
std::string json_string(std::string_view text);

}  // namespace firn
