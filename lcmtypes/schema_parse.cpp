#include <algorithm>
#include <cctype>
#include <charconv>
#include <stdexcept>

#include "lcmtypes/schema.h"

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
  explicit Parser(std::string_view text) : rest_(text) { advance(); }

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
    throw std::invalid_argument("LCM types: line " + std::to_string(line_) + ": " + what);
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
      Dimension d;
      d.text = std::string(token_);
      const auto [end, error] = std::from_chars(token_.data(), token_.data() + token_.size(), d.size);
      d.variable = error != std::errc{} || end != token_.data() + token_.size();
      if (d.variable) check_counter(type, d.text);
      if (!d.variable && d.size < 1) fail(m.name + ": array size " + d.text + " is not positive");
      advance();
      expect("]");
      m.dimensions.push_back(std::move(d));
    }
    if (m.dimensions.size() > kMaxDimensions)
      fail(m.name + ": more than " + std::to_string(kMaxDimensions) + " dimensions");
    return m;
  }

  void check_counter(const Type& type, const std::string& counter) const {
    for (const Member& m : type.members)
      if (m.name == counter && m.kind <= Kind::kInt64 && m.dimensions.empty()) return;
    fail("array size '" + counter + "' is no integer member before the array");
  }

  std::string_view rest_, token_;
  std::ptrdiff_t line_ = 1;
};

using Names = std::map<std::string, const Type*, std::less<>>;

const Type* resolve(const Names& names, const Type& user, const std::string& name) {
  for (const std::string& full : {user.package + "." + name, name})
    if (const auto it = names.find(full); it != names.end()) return it->second;
  throw std::invalid_argument("LCM types: " + user.name + ": unknown type '" + name + "'");
}

// Resolves structs that stand alone into fields of `out`, sums hashes. A type that contains itself is
// refused.
struct Nesting {
  std::vector<const Type*> parents;
  std::size_t structs = 0;  // resolved so far: doubling at each level must not run away
};
constexpr std::size_t kMostNested = 32, kMostStructs = 10000;

std::uint64_t flatten(const Names& names, const Type& type, const std::string& prefix, Type& out,
                      Nesting& nesting) {
  std::vector<const Type*>& parents = nesting.parents;
  if (std::find(parents.begin(), parents.end(), &type) != parents.end())
    throw std::invalid_argument("LCM types: " + type.name + " contains itself");
  if (parents.size() == kMostNested || ++nesting.structs > kMostStructs)
    throw std::invalid_argument("LCM types: " + type.name + " is nested too deeply or too often");
  parents.push_back(&type);
  std::uint64_t hash = type.struct_hash;
  std::map<std::string, int, std::less<>> counters;
  for (const Member& m : type.members)
    for (const Dimension& d : m.dimensions)
      if (d.variable && counters.emplace(d.text, int(out.slots)).second) ++out.slots;
  if (out.slots > kMaxSlots)
    throw std::invalid_argument("LCM types: " + out.name + " counts too many arrays");
  for (const Member& m : type.members) {
    Field f{prefix + m.name, m.kind, m.dimensions, -1, nullptr};
    for (Dimension& d : f.dimensions)
      if (d.variable) d.slot = counters.at(d.text);
    if (const auto it = counters.find(m.name); it != counters.end()) f.slot = it->second;
    if (m.kind == Kind::kStruct) {
      f.element = resolve(names, type, m.type);
      Type whole;  // of an array's element only hash and size matter here
      whole.name = m.type;
      Type& into = f.dimensions.empty() ? out : whole;
      hash += flatten(names, *f.element, f.dimensions.empty() ? f.path + "." : "", into, nesting);
      if (f.dimensions.empty()) continue;
      if (whole.smallest_bytes == 0)
        throw std::invalid_argument("LCM types: " + type.name + "." + m.name +
                                    " is an array of an empty type");
    }
    std::size_t smallest = m.kind == Kind::kString ? 5 : m.kind == Kind::kStruct ? 1 : size_of(m.kind);
    for (const Dimension& d : f.dimensions) smallest *= d.variable ? 0 : std::size_t(d.size);
    out.smallest_bytes += smallest;
    out.fields.push_back(std::move(f));
  }
  parents.pop_back();
  return (hash << 1) + (hash >> 63);
}

}  // namespace

std::size_t size_of(Kind kind) {
  for (const Primitive& p : kPrimitives)
    if (p.kind == kind) return p.size;
  return 0;
}

}  // namespace schema

Schema Schema::parse(std::string_view texts) {
  Schema s;
  schema::Parser(texts).run(s.types_);
  for (const schema::Type& t : s.types_) {
    if (!s.by_name_.emplace(t.package + "." + t.name, &t).second)
      throw std::invalid_argument("LCM types: " + t.package + "." + t.name + " is defined twice");
    s.by_name_.emplace(t.name, &t);
  }
  for (schema::Type& t : s.types_) {
    schema::Nesting nesting;
    t.fingerprint = std::int64_t(schema::flatten(s.by_name_, t, "", t, nesting));
    s.by_fingerprint_.emplace(t.fingerprint, &t);
  }
  return s;
}

const Schema& Schema::builtin() {
  static const Schema s = parse(lcm_type_texts());
  return s;
}

const schema::Type* Schema::find(std::string_view name) const {
  const auto it = by_name_.find(name);
  return it == by_name_.end() ? nullptr : it->second;
}

const schema::Type* Schema::find_fingerprint(std::int64_t fingerprint) const {
  const auto it = by_fingerprint_.find(fingerprint);
  return it == by_fingerprint_.end() ? nullptr : it->second;
}

}  // namespace firn
