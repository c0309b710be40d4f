#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "lcmtypes/schema_build.h"

namespace firn {
namespace schema {
namespace {

struct Primitive {
  std::string_view name;
  Kind kind;
  std::size_t size;
};
constexpr Primitive kPrimitives[] = {
    {"int8_t", Kind::kInt8, 1},   {"int16_t", Kind::kInt16, 2}, {"int32_t", Kind::kInt32, 4},
    {"int64_t", Kind::kInt64, 8}, {"byte", Kind::kByte, 1},     {"boolean", Kind::kBoolean, 1},
    {"float", Kind::kFloat, 4},   {"double", Kind::kDouble, 8}, {"string", Kind::kString, 0},
};

const Primitive* primitive(std::string_view name) {
  for (const Primitive& p : kPrimitives)
    if (p.name == name) return &p;
  return nullptr;
}

// lcm-gen's hash [lcmgen.c: hash_update, hash_string_update, lcm_struct_hash]; the type's own name is not in
// it.
std::uint64_t hash_byte(std::uint64_t v, std::uint8_t c) {
  const std::int64_t s = std::int64_t(v);
  return ((v << 8) ^ std::uint64_t(s >> 55)) + std::uint64_t(std::int64_t(std::int8_t(c)));
}

std::uint64_t hash_text(std::uint64_t v, std::string_view text) {
  v = hash_byte(v, std::uint8_t(text.size()));
  for (const char c : text) v = hash_byte(v, std::uint8_t(c));
  return v;
}

std::uint64_t struct_hash(const std::vector<Member>& members) {
  std::uint64_t v = 0x12345678;
  for (const Member& m : members) {
    v = hash_text(v, m.name);
    if (m.kind != Kind::kStruct) v = hash_text(v, m.type);
    v = hash_byte(v, std::uint8_t(m.dimensions.size()));
    for (const Dimension& d : m.dimensions) v = hash_text(hash_byte(v, d.variable ? 1 : 0), d.text);
  }
  return v;
}

// lcm-gen's hash of an enumeration [lcmgen.c: lcm_enum_hash]: values may be added later.
std::uint64_t enumeration_hash(std::string_view name) { return hash_text(0x87654321, name); }

// A whole number as strtoll reads it with base 0: decimal, 0x hexadecimal, 0 octal.
std::optional<std::int64_t> whole_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  const int base = hexadecimal ? 16 : text.starts_with('0') && text.size() > 1 ? 8 : 10;
  if (hexadecimal) text.remove_prefix(2);
  std::uint64_t magnitude = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), magnitude, base);
  constexpr auto kMost = std::uint64_t(std::numeric_limits<std::int64_t>::max());
  if (error != std::errc{} || end != text.data() + text.size() || magnitude > kMost + (negative ? 1 : 0))
    return {};
  return std::int64_t(negative ? 0 - magnitude : magnitude);
}

// A constant of a struct.
struct Constant {
  Kind kind;
  std::string text;  // of its value, as written: lcm-gen hashes it where the constant is the size of an array
};
using Constants = std::map<std::string, Constant, std::less<>>;

class Parser {
 public:
  /// @param file named in errors and as the origin of types; empty: the types of the house
  Parser(std::string_view text, std::string_view file) : rest_(text), file_(file) { advance(); }

  void run(std::deque<Type>& types) {
    std::string package;
    while (!token_.empty()) {
      if (accept("package")) {
        package = name();
        expect(";");
      } else if (accept("struct")) {
        types.push_back(structure(package));
      } else if (accept("enum")) {
        types.push_back(enumeration(package));
      } else {
        fail("'package', 'struct' or 'enum' expected, found '" + std::string(token_) + "'");
      }
    }
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument((file_.empty() ? "LCM types" : std::string(file_)) + ": line " +
                                std::to_string(line_) + ": " + what);
  }

  void skip_blanks() {
    while (!rest_.empty()) {
      std::size_t n = 0;
      if (std::isspace(static_cast<unsigned char>(rest_[0]))) {
        n = 1;
      } else if (rest_.starts_with("//")) {
        n = std::min(rest_.find('\n'), rest_.size());
      } else if (rest_.starts_with("/*")) {
        const std::size_t end = rest_.find("*/", 2);
        if (end == rest_.npos) fail("comment without end");
        n = end + 2;
      } else {
        return;
      }
      line_ += std::count(rest_.begin(), rest_.begin() + std::ptrdiff_t(n), '\n');
      rest_.remove_prefix(n);
    }
  }

  void advance() {
    skip_blanks();
    const auto is_word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-' || c == '+';
    };
    std::size_t n = 0;
    while (n < rest_.size() && is_word(rest_[n])) ++n;
    if (n == 0 && !rest_.empty()) n = 1;
    token_ = rest_.substr(0, n);
    rest_.remove_prefix(n);
  }

  bool accept(std::string_view word) {
    if (token_ != word) return false;
    advance();
    return true;
  }
  void expect(std::string_view word) {
    if (!accept(word)) fail("'" + std::string(word) + "' expected, found '" + std::string(token_) + "'");
  }
  std::string name() {
    if (token_.empty() || !(std::isalpha(static_cast<unsigned char>(token_[0])) || token_[0] == '_'))
      fail("name expected, found '" + std::string(token_) + "'");
    std::string n(token_);
    advance();
    return n;
  }

  Type begin_type(const std::string& package) {
    Type type;
    type.package = package;
    if (!file_.empty()) type.origin = std::string(file_) + ":" + std::to_string(line_);
    type.name = name();
    expect("{");
    return type;
  }

  Type structure(const std::string& package) {
    Type type = begin_type(package);
    Constants constants;
    while (!accept("}")) {
      if (accept("const")) {
        read_constants(type, constants);
        continue;
      }
      const std::string member_type = name();
      do {
        type.members.push_back(member(type, constants, member_type));
      } while (accept(","));
      expect(";");
    }
    type.struct_hash = struct_hash(type.members);
    return type;
  }

  // Encoded as an int32_t; the values may be left without commas or end with semicolons.
  Type enumeration(const std::string& package) {
    Type type = begin_type(package);
    while (!accept("}")) {
      const std::string value_name = name();
      if (accept("=")) {
        if (!whole_number(token_))
          fail(value_name + ": a whole number expected, found '" + std::string(token_) + "'");
        advance();
      }
      while (accept(",") || accept(";")) {
      }
    }
    type.enumeration = true;
    type.members.push_back({"value", "int32_t", Kind::kInt32, {}});
    type.struct_hash = enumeration_hash(type.name);
    return type;
  }

  // "int32_t ROWS = 0x2, COLS = 2;"
  void read_constants(const Type& type, Constants& constants) {
    const Primitive* p = primitive(token_);
    if (!p || p->kind == Kind::kByte || p->kind == Kind::kBoolean || p->kind == Kind::kString)
      fail("a constant is of an integer type, float or double, found '" + std::string(token_) + "'");
    advance();
    do {
      const std::string constant = new_name(type, constants);
      expect("=");
      if (p->kind <= Kind::kInt64) check_constant(constant, *p);
      constants.emplace(constant, Constant{p->kind, std::string(token_)});
      advance();
    } while (accept(","));
    expect(";");
  }

  void check_constant(const std::string& constant, const Primitive& p) const {
    const auto value = whole_number(token_);
    const int unused_bits = 64 - int(8 * p.size);
    if (!value || *value != (*value << unused_bits) >> unused_bits)
      fail(constant + ": '" + std::string(token_) + "' is no value of " + std::string(p.name));
  }

  std::string new_name(const Type& type, const Constants& constants) {
    if (constants.contains(token_) ||
        std::ranges::find(type.members, token_, &Member::name) != type.members.end())
      fail("'" + std::string(token_) + "' is declared twice in " + type.name);
    return name();
  }

  Member member(const Type& type, const Constants& constants, const std::string& member_type) {
    const Primitive* p = primitive(member_type);
    Member m{new_name(type, constants), member_type, p ? p->kind : Kind::kStruct, {}};
    while (accept("[")) {
      m.dimensions.push_back(dimension(type, constants, m.name));
      advance();
      expect("]");
    }
    if (m.dimensions.size() > kMaxDimensions)
      fail(m.name + ": more than " + std::to_string(kMaxDimensions) + " dimensions");
    return m;
  }

  // A number, a constant of the same struct, or a counting member.
  Dimension dimension(const Type& type, const Constants& constants, const std::string& member) const {
    const auto is_number = [](std::string_view text) {
      return !text.empty() && (std::isdigit(static_cast<unsigned char>(text[0])) || text[0] == '-');
    };
    const auto constant = constants.find(token_);
    Dimension d;
    d.text = std::string(token_);
    std::string shown = d.text;
    if (constant != constants.end()) {
      d.text = constant->second.text;
      shown += " = " + d.text;
      if (constant->second.kind > Kind::kInt64) fail(member + ": array size " + shown + " is no integer");
    } else if (!is_number(token_)) {
      d.variable = true;
      check_counter(type, d.text);
      return d;
    }
    const auto size = whole_number(d.text);
    if (!size) fail(member + ": array size " + shown + " is not a number");
    if (*size < 1) fail(member + ": array size " + shown + " is not positive");
    if (*size > std::numeric_limits<std::int32_t>::max())
      fail(member + ": array size " + shown + " is above 2147483647");
    d.size = std::int32_t(*size);
    return d;
  }

  void check_counter(const Type& type, const std::string& counter) const {
    for (const Member& m : type.members)
      if (m.name == counter && m.kind <= Kind::kInt64 && m.dimensions.empty()) return;
    fail("array size '" + counter + "' is no integer member or constant of " + type.name +
         " before the array");
  }

  std::string_view rest_, token_, file_;
  std::ptrdiff_t line_ = 1;
};

}  // namespace

void parse_types(std::string_view text, std::string_view file, std::deque<Type>& types) {
  Parser(text, file).run(types);
}

std::size_t size_of(Kind kind) {
  for (const Primitive& p : kPrimitives)
    if (p.kind == kind) return p.size;
  return 0;
}

}  // namespace schema
}  // namespace firn
