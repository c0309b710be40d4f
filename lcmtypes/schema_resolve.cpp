#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "lcmtypes/schema_build.h"

namespace firn {
namespace schema {
namespace {

constexpr std::size_t kMaxNested = 32, kMaxStructs = 10000;
constexpr std::size_t kEndless = std::size_t(1) << 40;  // bytes; more than any message

// A name with a package stands for itself; another one is looked for in the user's package first.
const Type& find_type(const Names& names, const Type& user, const std::string& name) {
  const bool whole = name.find('.') != name.npos;
  for (const std::string& full : {whole ? name : user.package + "." + name, name})
    if (const auto it = names.find(full); it != names.end()) return *it->second;
  throw std::invalid_argument("LCM types: " + user.name + ": unknown type '" + name + "'");
}

std::size_t capped_product(std::size_t a, std::size_t b) {
  std::size_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? kEndless : std::min(product, kEndless);
}

class Resolver {
 public:
  explicit Resolver(const Names& names) : names_(names) {}

  // A type inside itself counts nothing [lcm-gen, emit_cpp.c: _computeHash].
  std::uint64_t hash(const Type& type) {
    if (std::ranges::find(parents_, &type) != parents_.end()) return 0;
    if (type.enumeration) return type.struct_hash;
    enter(type);
    std::uint64_t sum = type.struct_hash;
    for (const Member& m : type.members)
      if (m.kind == Kind::kStruct) sum += hash(find_type(names_, type, m.type));
    parents_.pop_back();
    return (sum << 1) + (sum >> 63);
  }

  // Bytes of the shortest encoded value.
  std::size_t smallest(const Type& type) {
    if (const auto it = smallest_.find(&type); it != smallest_.end()) return it->second;
    refuse_itself(type);
    enter(type);
    std::size_t sum = 0;
    for (const Member& m : type.members) {
      const bool counted = std::ranges::any_of(m.dimensions, &Dimension::variable);
      if (counted) continue;
      std::size_t bytes = m.kind == Kind::kString   ? 5
                          : m.kind == Kind::kStruct ? smallest(find_type(names_, type, m.type))
                                                    : size_of(m.kind);
      for (const Dimension& d : m.dimensions) bytes = capped_product(bytes, std::size_t(d.size));
      sum = std::min(sum + bytes, kEndless);
    }
    parents_.pop_back();
    return smallest_[&type] = sum;
  }

  // Resolves structs that stand alone into fields of `out`.
  void flatten(const Type& type, const std::string& prefix, Type& out) {
    refuse_itself(type);
    enter(type);
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
        const Type& element = find_type(names_, type, m.type);
        if (element.enumeration) {
          f.kind = Kind::kInt32;
          out.fields.push_back(std::move(f));
          continue;
        }
        if (m.dimensions.empty()) {
          flatten(element, f.path + ".", out);
          continue;
        }
        f.element = &element;
        if (Resolver(names_).smallest(element) == 0)
          throw std::invalid_argument("LCM types: " + type.name + "." + m.name +
                                      " is an array of an empty type");
      }
      out.fields.push_back(std::move(f));
    }
    parents_.pop_back();
  }

 private:
  void enter(const Type& type) {
    if (parents_.size() == kMaxNested || ++structs_ > kMaxStructs)
      throw std::invalid_argument("LCM types: " + type.name + " is nested too deeply or too often");
    parents_.push_back(&type);
  }
  void refuse_itself(const Type& type) const {
    if (std::ranges::find(parents_, &type) != parents_.end())
      throw std::invalid_argument("LCM types: " + type.name + " contains itself");
  }

  const Names& names_;
  std::vector<const Type*> parents_;
  std::map<const Type*, std::size_t> smallest_;
  std::size_t structs_ = 0;  // resolved so far: doubling at each level must not run away
};

bool same_members(const Type& a, const Type& b) {
  return a.struct_hash == b.struct_hash &&
         std::ranges::equal(a.members, b.members, [](const Member& x, const Member& y) {
           return x.name == y.name && x.type == y.type;
         });
}

}  // namespace

void resolve(const Names& names, Type& type) {
  type.smallest_bytes = Resolver(names).smallest(type);
  type.fingerprint = std::int64_t(Resolver(names).hash(type));
  Resolver(names).flatten(type, "", type);
}

}  // namespace schema

Schema Schema::parse(std::string_view texts) {
  Schema s;
  schema::parse_types(texts, "", s.types_);
  for (const schema::Type& t : s.types_) {
    if (!s.by_name_.emplace(t.package + "." + t.name, &t).second)
      throw std::invalid_argument("LCM types: " + t.package + "." + t.name + " is defined twice");
    s.by_name_.emplace(t.name, &t);
  }
  for (schema::Type& t : s.types_) {
    schema::resolve(s.by_name_, t);
    s.keep(t);
  }
  return s;
}

void Schema::keep(const schema::Type& type) {
  by_fingerprint_.emplace(type.fingerprint, &type);
  readable_.push_back(&type);
}

Schema Schema::parse_files(std::span<const TypeFile> files, std::vector<std::string>& problems) {
  Schema s;
  for (const TypeFile& file : files) {
    std::deque<schema::Type> found;
    try {
      schema::parse_types(file.text, file.name, found);
    } catch (const std::invalid_argument& e) {
      problems.push_back(e.what());
    }
    for (schema::Type& t : found) {
      const std::string name = t.package.empty() ? t.name : t.package + "." + t.name;
      const auto known = s.by_name_.find(name);
      if (known == s.by_name_.end()) {
        s.types_.push_back(std::move(t));
        s.by_name_[name] = &s.types_.back();
      } else if (!schema::same_members(*known->second, t)) {
        problems.push_back(t.origin + ": " + name + " differs from the one of " + known->second->origin +
                           ", which is used");
      }
    }
  }
  for (const schema::Type& t : s.types_) s.by_name_.emplace(t.name, &t);
  std::set<const schema::Type*> unresolved;
  const auto refuse = [&](const schema::Type& t, const std::string& why) {
    problems.push_back(t.origin + ": " + why);
    unresolved.insert(&t);
  };
  for (schema::Type& t : s.types_) try {
      schema::resolve(s.by_name_, t);
    } catch (const std::invalid_argument& e) {
      refuse(t, e.what());
    }
  for (std::size_t known = 1, before = 0; known != before;) {  // until no more types hold an unreadable one
    before = unresolved.size();
    for (const schema::Type& t : s.types_)
      for (const schema::Field& f : t.fields)
        if (f.element && unresolved.contains(f.element) && !unresolved.contains(&t))
          refuse(t, t.name + "." + f.path + " is of " + f.element->name + ", which cannot be read");
    known = unresolved.size();
  }
  for (const schema::Type& t : s.types_)
    if (!unresolved.contains(&t)) s.keep(t);
  std::erase_if(s.by_name_, [&](const auto& row) { return unresolved.contains(row.second); });
  return s;
}

std::vector<const schema::Type*> Schema::all_of(std::int64_t fingerprint) const {
  std::vector<const schema::Type*> same;
  for (const schema::Type* t : readable_)
    if (t->fingerprint == fingerprint) same.push_back(t);
  return same;
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
