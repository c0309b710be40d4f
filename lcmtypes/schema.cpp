#include "lcmtypes/schema.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/options/enumerators.h"
#include "lcmtypes/schema_walk.h"

namespace firn {

using namespace schema;

namespace {

static_assert(kSizes.size() == kTableSize<Kind>);

struct PlaceSink : NullSink {
  std::span<FieldPlace> places;
  const Type* type = nullptr;
  int depth = 0;  // inside an array of structs the indices are another type's
  void numbers(const Field&, std::size_t i, std::size_t offset, const Counts& c) {
    if (depth == 0) places[i] = {offset, c.total};
  }
  void strings(const Field&, std::size_t i, std::size_t offset, const Counts& c) {
    if (depth == 0) places[i] = {offset, c.total};
  }
  void element(const Field&, const Counts&, std::size_t) { ++depth; }
  void end_element(const Field&, const Counts&, std::size_t) { --depth; }
};

Leaf number_leaf(std::string_view path, Kind kind, std::span<const std::byte> m, std::size_t offset) {
  const std::byte* p = m.data() + offset;
  const bool real = kind == Kind::kFloat || kind == Kind::kDouble;
  return {path, kind, offset, kSizes[std::size_t(kind)],
          real ? LeafValue(real_at(kind, p)) : LeafValue(integer_at(kind, p))};
}

// Every leaf in turn, or only the one that holds byte `wanted`.
struct LeafSink : NullSink {
  std::span<const std::byte> message;
  const std::function<bool(const Leaf&)>* visit = nullptr;
  std::optional<std::size_t> wanted;
  bool stop = false;
  std::string prefix;
  std::vector<std::size_t> prefix_ends;

  void numbers(const Field& f, std::size_t, std::size_t offset, const Counts& c) {
    const std::size_t size = kSizes[std::size_t(f.kind)];
    std::size_t k = 0, end = c.total;
    if (wanted) {
      if (*wanted < offset || *wanted >= offset + c.total * size) return;
      k = (*wanted - offset) / size;
      end = k + 1;
    }
    for (; k < end && !stop; ++k) {
      const std::string path = prefix + element_path(f.path, c, k);
      stop = !(*visit)(number_leaf(path, f.kind, message, offset + k * size));
    }
  }
  void string(const Field& f, std::size_t offset, std::string_view text, const Counts& c, std::size_t k) {
    const std::size_t bytes = text.size() + 5;
    if (stop || (wanted && (*wanted < offset || *wanted >= offset + bytes))) return;
    const std::string path = prefix + element_path(f.path, c, k);
    stop = !(*visit)({path, Kind::kString, offset, bytes, text});
  }
  void element(const Field& f, const Counts& c, std::size_t k) {
    prefix_ends.push_back(prefix.size());
    prefix += element_path(f.path, c, k) + ".";
  }
  void end_element(const Field&, const Counts&, std::size_t) {
    prefix.resize(prefix_ends.back());
    prefix_ends.pop_back();
  }
};

struct Found {
  std::string path, text;
};

// The leaf of `m` that holds byte `at`, or the member whose damage starts there.
std::optional<Found> leaf_at(const Type& type, std::span<const std::byte> m, std::size_t at) {
  std::optional<Found> found;
  const std::function<bool(const Leaf&)> visit = [&](const Leaf& leaf) {
    found = Found{std::string(leaf.path), to_text(leaf)};
    return false;
  };
  LeafSink sink;
  sink.message = m;
  sink.visit = &visit;
  sink.wanted = at;
  std::size_t pos = 8;
  const auto error = walk(type, m, pos, sink);
  if (!found && error && at >= error->offset) found = Found{error->path, "(damaged: " + error->message + ")"};
  return found;
}

}  // namespace

const Type* Schema::type_of(std::span<const std::byte> message) const {
  return message.size() < 8 ? nullptr : find_fingerprint(std::int64_t(big_endian(message.data(), 8)));
}

std::optional<SizeError> check(const Type& type, std::span<const std::byte> message) {
  NullSink sink;
  return walk_message(type, message, sink);
}

std::optional<SizeError> check_members(const Type& type, std::span<const std::byte> message) {
  NullSink sink;
  return walk_members(type, message, sink);
}

std::optional<SizeError> check(const Type& type, std::span<const std::byte> message,
                               std::span<FieldPlace> places) {
  PlaceSink sink;
  sink.places = places;
  return walk_message(type, message, sink);
}

std::optional<SizeError> for_each_leaf(const Type& type, std::span<const std::byte> message,
                                       const std::function<bool(const Leaf&)>& visit) {
  LeafSink sink;
  sink.message = message;
  sink.visit = &visit;
  return walk_message(type, message, sink);
}

std::optional<FieldDifference> first_difference(const Type& type, std::span<const std::byte> a,
                                                std::span<const std::byte> b) {
  const auto [pa, pb] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  const std::size_t at = std::size_t(pa - a.begin());
  if (pa == a.end() && pb == b.end()) return {};
  if (at < 8) {
    const auto name = [](std::span<const std::byte> m) {
      const Type* t = Schema::builtin().type_of(m);
      return t              ? t->name
             : m.size() < 8 ? std::string("(missing)")
                            : "unknown fingerprint " + std::to_string(std::int64_t(big_endian(m.data(), 8)));
    };
    return FieldDifference{"(fingerprint)", name(a), name(b), at};
  }
  const auto in_a = leaf_at(type, a, at), in_b = leaf_at(type, b, at);
  if (!in_a && !in_b)
    return FieldDifference{"(length)", std::to_string(a.size()) + " bytes",
                           std::to_string(b.size()) + " bytes", at};
  return FieldDifference{in_a ? in_a->path : in_b->path, in_a ? in_a->text : "(missing)",
                         in_b ? in_b->text : "(missing)", at};
}

std::string to_text(const Leaf& leaf) {
  if (const auto* n = std::get_if<std::int64_t>(&leaf.value)) return std::to_string(*n);
  if (const auto* s = std::get_if<std::string_view>(&leaf.value)) return json_string(*s);
  const double v = std::get<double>(leaf.value);
  char text[40];
  if (std::isnan(v)) {  // a NaN's payload can differ
    char* end = std::to_chars(text, text + sizeof text, std::bit_cast<std::uint64_t>(v), 16).ptr;
    return "nan (0x" + std::string(text, end) + ")";
  }
  const auto r = leaf.kind == Kind::kFloat ? std::to_chars(text, text + sizeof text, float(v))
                                           : std::to_chars(text, text + sizeof text, v);
  return {text, r.ptr};
}

}  // namespace firn
