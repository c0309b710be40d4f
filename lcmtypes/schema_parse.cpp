#include <algorithm>
#include <cctype>
#include <charconv>
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
      } else {
        fail("'package' or 'struct' expected, found '" + std::string(token_) + "'");
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

  Type structure(const std::string& package) {
    Type type;
    type.package = package;
    if (!file_.empty()) type.origin = std::string(file_) + ":" + std::to_string(line_);
    type.name = name();
    expect("{");
    while (!accept("}")) {
      if (accept("const")) {
        while (!token_.empty() && token_ != ";") advance();
        expect(";");
        continue;
      }
      const std::string member_type = name();
      do {
        type.members.push_back(member(type, member_type));
      } while (accept(","));
      expect(";");
    }
    type.struct_hash = struct_hash(type.members);
    return type;
  }

  Member member(const Type& type, const std::string& member_type) {
    const Primitive* p = primitive(member_type);
    Member m{name(), member_type, p ? p->kind : Kind::kStruct, {}};
    while (accept("[")) {
      const Dimension d = dimension(type, m.name);
      advance();
      expect("]");
      m.dimensions.push_back(d);
    }
    if (m.dimensions.size() > kMaxDimensions)
      fail(m.name + ": more than " + std::to_string(kMaxDimensions) + " dimensions");
    return m;
  }

  // A number as strtol reads it with base 0, or a counting member.
  Dimension dimension(const Type& type, const std::string& member) const {
    Dimension d;
    d.text = std::string(token_);
    d.variable = token_.empty() || !(std::isdigit(static_cast<unsigned char>(token_[0])) || token_[0] == '-');
    if (d.variable) {
      check_counter(type, d.text);
      return d;
    }
    std::string_view digits = token_;
    const bool hexadecimal = digits.starts_with("0x") || digits.starts_with("0X");
    const int base = hexadecimal ? 16 : digits.starts_with("0") && digits.size() > 1 ? 8 : 10;
    if (hexadecimal) digits.remove_prefix(2);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), d.size, base);
    if (error != std::errc{} || end != digits.data() + digits.size())
      fail(member + ": array size " + d.text + " is not a number");
    if (d.size < 1) fail(member + ": array size " + d.text + " is not positive");
    return d;
  }

  void check_counter(const Type& type, const std::string& counter) const {
    for (const Member& m : type.members)
      if (m.name == counter && m.kind <= Kind::kInt64 && m.dimensions.empty()) return;
    fail("array size '" + counter + "' is no integer member before the array");
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
