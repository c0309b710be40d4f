#include "lcmtypes/validate.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/grid/avx2.h"
#include "lcmtypes/limits.h"
#include "lcmtypes/schema.h"
#include "lcmtypes/schema_walk.h"

namespace firn {

using namespace schema;

namespace {

constexpr std::size_t kMaxFields = 64;

struct Check {
  std::size_t field;
  Kind kind;
  Limit limit;
  int when = -1;  // field
};

struct RelationCheck {
  Relation relation;
  std::size_t a, b, c;
  int when = -1;
};

struct Plan {
  const Type* type = nullptr;
  std::vector<Check> checks;
  std::vector<RelationCheck> relations;
};

int field_index(const Type& type, std::string_view path) {
  for (std::size_t i = 0; i < type.fields.size(); ++i)
    if (type.fields[i].path == path) return int(i);
  return -1;
}

bool is_real(Kind k) { return k == Kind::kFloat || k == Kind::kDouble; }

const Limit* general_limit(const Type& type, const Field& field) {
  for (const Limit& l : limits())
    if (l.when.empty() && l.type == type.name && l.path == field.path) return &l;
  return nullptr;
}

Plan plan_for(const Type& type) {
  Plan plan{&type, {}, {}};
  if (type.fields.size() > kMaxFields)
    throw std::logic_error(type.name + " has more members than validate() can hold");
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    const Field& f = type.fields[i];
    if (f.kind == Kind::kStruct) continue;
    constexpr double kAny = std::numeric_limits<double>::max();
    if (const Limit* l = general_limit(type, f); l && f.kind != Kind::kString) {
      const bool whole_range = f.kind == Kind::kByte && l->low <= 0 && l->high >= 255;
      if (!whole_range) plan.checks.push_back({i, f.kind, *l});
    } else if (f.kind == Kind::kString) {
      plan.checks.push_back({i, f.kind, {"", "", 0, double(kMaxTextBytes)}});
    } else if (is_real(f.kind)) {  // finite, whatever else it means
      plan.checks.push_back({i, f.kind, {"", "", -kAny, kAny, false, !f.dimensions.empty()}});
    }
    for (const Limit& l : limits())
      if (!l.when.empty() && l.type == type.name && l.path == f.path)
        plan.checks.push_back({i, f.kind, l, field_index(type, l.when)});
  }
  for (const Relation& r : relations()) {
    if (r.type != type.name) continue;
    const int a = field_index(type, r.a), b = field_index(type, r.b),
              c = r.c.empty() ? 0 : field_index(type, r.c);
    if (a < 0 || b < 0 || c < 0) continue;  // tests/lcmtypes/limit_rows.h names it
    plan.relations.push_back(
        {r, std::size_t(a), std::size_t(b), std::size_t(c), r.when.empty() ? -1 : field_index(type, r.when)});
  }
  return plan;
}

const std::map<std::int64_t, Plan>& plans() {
  static const std::map<std::int64_t, Plan> all = [] {
    std::map<std::int64_t, Plan> m;
    for (const Type& t : Schema::builtin().types()) m.emplace(t.fingerprint, plan_for(t));
    return m;
  }();
  return all;
}

double number_at(Kind kind, const std::byte* p) {
  return is_real(kind) ? real_at(kind, p) : double(integer_at(kind, p));
}

bool inside(const Limit& l, double v) {
  if (std::isnan(v)) return l.nan_ok;
  return (l.above_low ? v > l.low : v >= l.low) && v <= l.high;
}

// Is any of n signed bytes outside 0..high (<= 127)? Eight at a time.
bool any_outside(const std::byte* p, std::size_t n, unsigned high) {
  constexpr std::uint64_t kOnes = 0x0101010101010101u, kTops = 0x8080808080808080u;
  const std::uint64_t lift = kOnes * (127u - high);
  std::uint64_t bad = 0;
  for (; n >= 8; n -= 8, p += 8) {
    std::uint64_t x;
    std::memcpy(&x, p, 8);
    bad |= x | ((x & ~kTops) + lift);
  }
  for (; n > 0; --n, ++p) bad |= std::uint64_t(*p) > high ? kTops : 0;
  return (bad & kTops) != 0;
}

/// Is any of n big-endian reals outside -high..high, or NaN unless nan_ok?
template <class Bits, Bits kInfinite>
[[gnu::always_inline]] inline bool any_real_outside(const std::byte* p, std::size_t n, Bits high,
                                                    bool nan_ok) {
  const Bits most = nan_ok ? kInfinite : std::numeric_limits<Bits>::max();
  Bits bad = 0;
  for (std::size_t i = 0; i < n; ++i) {
    Bits x;
    std::memcpy(&x, p + sizeof x * i, sizeof x);
    if constexpr (sizeof x == 4)
      x = __builtin_bswap32(x);
    else
      x = __builtin_bswap64(x);
    x &= std::numeric_limits<Bits>::max() >> 1;
    bad |= Bits(x > high) & Bits(x <= most);
  }
  return bad != 0;
}
FIRN_CLONES bool any_float_outside(const std::byte* p, std::size_t n, std::uint32_t high, bool nan_ok) {
  return any_real_outside<std::uint32_t, 0x7f800000u>(p, n, high, nan_ok);
}
FIRN_CLONES bool any_double_outside(const std::byte* p, std::size_t n, std::uint64_t high, bool nan_ok) {
  return any_real_outside<std::uint64_t, 0x7ff0000000000000u>(p, n, high, nan_ok);
}

bool any_outside(Kind kind, const std::byte* p, std::size_t n, double high, bool nan_ok) {
  if (kind == Kind::kFloat) {
    const float most = float(std::min(high, double(std::numeric_limits<float>::max())));
    return any_float_outside(p, n, std::bit_cast<std::uint32_t>(most), nan_ok);
  }
  return any_double_outside(p, n, std::bit_cast<std::uint64_t>(high), nan_ok);
}

// First element outside the limit, or n.
std::size_t first_outside(const Check& c, const std::byte* p, std::size_t n) {
  const std::size_t size = kSizes[std::size_t(c.kind)];
  if (n > 1) {
    const Limit& l = c.limit;
    if (c.kind == Kind::kInt8 && l.low == 0 && l.high <= 127 && !any_outside(p, n, unsigned(l.high)))
      return n;
    if (is_real(c.kind) && l.low == -l.high && !l.above_low && !any_outside(c.kind, p, n, l.high, l.nan_ok))
      return n;
  }
  for (std::size_t k = 0; k < n; ++k)
    if (!inside(c.limit, number_at(c.kind, p + k * size))) return k;
  return n;
}

std::string text_of(double v) {
  char text[40];
  const bool whole = std::abs(v) < 1e16 && v == std::trunc(v);
  return std::string(text, whole ? std::to_chars(text, text + sizeof text, std::int64_t(v)).ptr
                                 : std::to_chars(text, text + sizeof text, v).ptr);
}

struct Message {
  std::span<const std::byte> bytes;
  std::array<FieldPlace, kMaxFields> places;
  const Type* type;

  double number(std::size_t field, std::size_t k = 0) const {
    const Kind kind = type->fields[field].kind;
    return number_at(kind, bytes.data() + places[field].offset + k * kSizes[std::size_t(kind)]);
  }
  bool holds_when(int when, double low, double high) const {
    return when < 0 || (number(std::size_t(when)) >= low && number(std::size_t(when)) <= high);
  }
  std::string name(std::size_t field, std::size_t k) const {
    const Field& f = type->fields[field];
    return f.dimensions.empty() ? f.path : f.path + "[" + std::to_string(k) + "]";
  }
  std::string at(std::size_t field, std::size_t k) const {
    return "byte " +
           std::to_string(places[field].offset + k * kSizes[std::size_t(type->fields[field].kind)]) + ": ";
  }
};

std::string describe(const Message& m, const Check& c, std::size_t k) {
  const Limit& l = c.limit;
  std::string range =
      l.high == std::numeric_limits<double>::max()
          ? "finite"
          : (l.above_low ? "above " + text_of(l.low) + " up to " : text_of(l.low) + "..") + text_of(l.high);
  std::string value = text_of(m.number(c.field, k));
  std::string said = m.at(c.field, k) + m.name(c.field, k) + " = " + value +
                     (range == "finite" ? " is not finite" : " is outside " + range);
  if (c.when >= 0)
    said += " (while " + std::string(l.when) + " = " + text_of(m.number(std::size_t(c.when))) + ")";
  return said;
}

std::optional<std::string> broken_limit(const Message& m, const Plan& plan) {
  for (const Check& c : plan.checks) {
    const FieldPlace& place = m.places[c.field];
    if (!m.holds_when(c.when, c.limit.when_low, c.limit.when_high)) continue;
    const std::byte* p = m.bytes.data() + place.offset;
    if (c.kind == Kind::kString) {
      // An array of strings is bounded by the message itself.
      if (plan.type->fields[c.field].dimensions.empty() && big_endian(p, 4) > kMaxTextBytes)
        return m.at(c.field, 0) + m.name(c.field, 0) + " is a text of " + std::to_string(big_endian(p, 4)) +
               " bytes, the limit is " + std::to_string(kMaxTextBytes);
      continue;
    }
    if (const std::size_t k = first_outside(c, p, place.count); k < place.count) return describe(m, c, k);
  }
  return {};
}

std::optional<std::string> broken_relation(const Message& m, const Plan& plan) {
  using K = Relation::Kind;
  for (const RelationCheck& r : plan.relations) {
    if (!m.holds_when(r.when, r.relation.when_low, r.relation.when_high)) continue;
    const auto say = [&](std::size_t k, const std::string& what) {
      return m.at(r.a, k) + m.name(r.a, k) + " = " + text_of(m.number(r.a, k)) + what;
    };
    const std::string b_name(r.relation.b);
    switch (r.relation.kind) {
      case K::kCells:
      case K::kCellsOrNone: {
        const double cells = m.number(r.b) * m.number(r.c), n = m.number(r.a);
        if (n == cells || (r.relation.kind == K::kCellsOrNone && n == 0)) break;
        return say(0, " is not " + b_name + " * " + std::string(r.relation.c) + " = " + text_of(cells));
      }
      case K::kLess:
        if (m.number(r.a) < m.number(r.b)) break;
        return say(0, " is not below " + b_name + " = " + text_of(m.number(r.b)));
      case K::kNotAbove:
        for (std::size_t k = 0; k < m.places[r.a].count; ++k)
          if (m.number(r.a, k) > m.number(r.b, k))
            return say(k, " is above " + m.name(r.b, k) + " = " + text_of(m.number(r.b, k)));
        break;
      case K::kAllNotAbove: {
        const Check all{r.a, m.type->fields[r.a].kind, {"", "", 0, m.number(r.b)}};
        const std::size_t n = m.places[r.a].count,
                          k = first_outside(all, m.bytes.data() + m.places[r.a].offset, n);
        if (k < n) return say(k, " is above " + b_name + " = " + text_of(m.number(r.b)));
        break;
      }
    }
  }
  return {};
}

}  // namespace

std::optional<std::string> validate(std::string_view channel, std::string_view type_name,
                                    std::span<const std::byte> message) {
  const auto say = [&](const std::string& what) { return std::string(channel) + ": " + what; };
  const auto& all = plans();
  const auto found = message.size() < 8 ? all.end() : all.find(std::int64_t(big_endian(message.data(), 8)));
  if (found == all.end() || found->second.type->name != type_name) {
    const Type* wanted = Schema::builtin().find(type_name);
    if (!wanted) return say("type '" + std::string(type_name) + "' is unknown");
    return say("byte 0: " + check_fingerprint(*wanted, message)->message);
  }
  const Plan& plan = found->second;
  Message m;
  m.bytes = message;
  m.type = plan.type;
  if (const auto e = check(*plan.type, message, m.places))
    return say("byte " + std::to_string(e->offset) + ": " + (e->path.empty() ? "" : e->path + ": ") +
               e->message);
  if (const auto e = broken_limit(m, plan)) return say(*e);
  if (const auto e = broken_relation(m, plan)) return say(*e);
  return {};
}

std::optional<std::string> validate(const ChannelInfo& channel, std::span<const std::byte> message) {
  return validate(channel.name, channel.type, message);
}

}  // namespace firn
