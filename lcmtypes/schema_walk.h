// Walks over an encoded message, for all functions of schema.h. For the schema_*.cpp files.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "lcmtypes/schema.h"

namespace firn::schema {

inline std::uint64_t big_endian(const std::byte* p, std::size_t bytes) {
  std::uint64_t v = 0;
  switch (bytes) {
    case 1:
      return std::uint64_t(*p);
    case 2: {
      std::uint16_t x;
      std::memcpy(&x, p, 2);
      return __builtin_bswap16(x);
    }
    case 4: {
      std::uint32_t x;
      std::memcpy(&x, p, 4);
      return __builtin_bswap32(x);
    }
    default:
      std::memcpy(&v, p, 8);
      return __builtin_bswap64(v);
  }
}

inline std::int64_t integer_at(Kind kind, const std::byte* p) {
  switch (kind) {
    case Kind::kByte:
      return std::int64_t(std::uint8_t(*p));
    case Kind::kInt16:
      return std::int16_t(big_endian(p, 2));
    case Kind::kInt32:
      return std::int32_t(big_endian(p, 4));
    case Kind::kInt64:
      return std::int64_t(big_endian(p, 8));
    default:
      return std::int8_t(*p);
  }
}

inline double real_at(Kind kind, const std::byte* p) {
  if (kind == Kind::kFloat) return double(std::bit_cast<float>(std::uint32_t(big_endian(p, 4))));
  return std::bit_cast<double>(big_endian(p, 8));
}

inline constexpr std::array<std::uint8_t, 10> kSizes{1, 2, 4, 8, 1, 1, 4, 8, 0, 0};

/// Counts of an array's dimensions as found in the message.
struct Counts {
  std::array<std::size_t, kMaxDimensions> n{};
  std::size_t rank = 0;
  std::size_t total = 1;
};

/// "cells[1][2]" of the k-th element.
inline std::string element_path(const std::string& path, const Counts& counts, std::size_t k) {
  std::array<std::size_t, kMaxDimensions> at{};
  for (std::size_t d = counts.rank; d-- > 0;) {
    at[d] = counts.n[d] ? k % counts.n[d] : 0;
    k = counts.n[d] ? k / counts.n[d] : 0;
  }
  std::string p = path;
  for (std::size_t d = 0; d < counts.rank; ++d) p += "[" + std::to_string(at[d]) + "]";
  return p;
}

// A sink of the walk's reports. It may stop it by setting `stop`.
struct NullSink {
  static constexpr bool stop = false;
  void numbers(const Field&, std::size_t /*index*/, std::size_t /*offset*/, const Counts&) {}
  void strings(const Field&, std::size_t /*index*/, std::size_t /*offset*/, const Counts&) {}
  void string(const Field&, std::size_t /*offset*/, std::string_view, const Counts&, std::size_t /*k*/) {}
  void end_strings(const Field&, const Counts&) {}
  void elements(const Field&, const Counts&) {}
  void element(const Field&, const Counts&, std::size_t /*k*/) {}
  void end_element(const Field&, const Counts&, std::size_t /*k*/) {}
};

inline SizeError cut(std::size_t offset, const std::string& path, std::size_t need, std::size_t left) {
  return {offset, path, "needs " + std::to_string(need) + " bytes, " + std::to_string(left) + " are left"};
}

// A string: i32 length with the final NUL, text, NUL. nullopt sets `text` and moves `at`.
inline std::optional<SizeError> read_string(const std::string& path, std::span<const std::byte> m,
                                            std::size_t& at, std::string_view& text) {
  if (m.size() - at < 5) return cut(at, path, 5, m.size() - at);
  const std::int32_t length = std::int32_t(big_endian(m.data() + at, 4));
  if (length < 1 || std::size_t(length) > m.size() - at - 4)
    return SizeError{
        at, path,
        "string length " + std::to_string(length) + " is outside 1.." + std::to_string(m.size() - at - 4)};
  text = {reinterpret_cast<const char*>(m.data() + at + 4), std::size_t(length) - 1};
  if (m[at + 3 + std::size_t(length)] != std::byte{0})
    return SizeError{at + 3 + std::size_t(length), path, "string does not end with a zero byte"};
  // LCM's encoder ends a string at its first zero: such a message would not be sent on as it came.
  if (const std::size_t zero = text.find('\0'); zero != text.npos)
    return SizeError{at + 4 + zero, path, "string has a zero byte inside"};
  at += 4 + std::size_t(length);
  return {};
}

// The element count of an array; each element takes at least `least` bytes.
inline std::optional<SizeError> count_elements(const Field& f, std::span<const std::int64_t> slots,
                                               std::size_t least, std::size_t at, std::size_t left,
                                               Counts& counts) {
  counts.rank = f.dimensions.size();
  const std::size_t most = left / least;
  for (std::size_t d = 0; d < counts.rank; ++d) {
    const Dimension& dim = f.dimensions[d];
    const std::int64_t n = dim.variable ? slots[std::size_t(dim.slot)] : dim.size;
    if (n < 0)
      return SizeError{at, f.path, "array size " + dim.text + " = " + std::to_string(n) + " is negative"};
    counts.n[d] = std::size_t(n);
    // Also a dimension beside a zero one makes the decoder allocate: none may claim more than could be there.
    const bool overflow = __builtin_mul_overflow(counts.total, counts.n[d], &counts.total);
    const bool last = d + 1 == counts.rank;
    if (overflow || counts.n[d] > std::max<std::size_t>(most, 4096) || (last && counts.total > most))
      return SizeError{at, f.path,
                       "array size " + dim.text + " = " + std::to_string(n) + " needs more than the " +
                           std::to_string(left) + " bytes that are left"};
  }
  return {};
}

/// Walks a value of `type` from `at` on; `at` ends behind it.
template <class Sink>
std::optional<SizeError> walk(const Type& type, std::span<const std::byte> m, std::size_t& at, Sink& sink,
                              int depth = 0) {
  if (depth > kMaxDepth)
    return SizeError{at, "",
                     type.name + " is nested in itself more than " + std::to_string(kMaxDepth) + " deep"};
  std::array<std::int64_t, kMaxSlots> slots;  // each is set by the member that counts, which comes first
  const Counts one;
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    if (sink.stop) return {};
    const Field& f = type.fields[i];
    const std::size_t size = kSizes[std::size_t(f.kind)];
    if (f.dimensions.empty()) {
      if (f.kind == Kind::kString) {
        const std::size_t start = at;
        std::string_view text;
        if (auto e = read_string(f.path, m, at, text)) return e;
        sink.strings(f, i, start, one);
        sink.string(f, start, text, one, 0);
        continue;
      }
      if (m.size() - at < size) return cut(at, f.path, size, m.size() - at);
      if (f.slot >= 0) slots[std::size_t(f.slot)] = integer_at(f.kind, m.data() + at);
      sink.numbers(f, i, at, one);
      at += size;
      continue;
    }
    Counts counts;
    const std::size_t least = size                      ? size
                              : f.kind == Kind::kString ? 5
                                                        : std::max<std::size_t>(f.element->smallest_bytes, 1);
    if (auto e = count_elements(f, slots, least, at, m.size() - at, counts)) return e;
    if (size) {
      sink.numbers(f, i, at, counts);
      at += counts.total * size;
    } else if (f.kind == Kind::kString) {
      sink.strings(f, i, at, counts);
      for (std::size_t k = 0; k < counts.total && !sink.stop; ++k) {
        const std::size_t start = at;
        std::string_view text;
        if (auto e = read_string(f.path, m, at, text)) {
          e->path = element_path(f.path, counts, k);
          return e;
        }
        sink.string(f, start, text, counts, k);
      }
      sink.end_strings(f, counts);
    } else {
      sink.elements(f, counts);
      for (std::size_t k = 0; k < counts.total && !sink.stop; ++k) {
        sink.element(f, counts, k);
        if (auto e = walk(*f.element, m, at, sink, depth + 1)) {
          e->path = element_path(f.path, counts, k) + "." + e->path;
          return e;
        }
        sink.end_element(f, counts, k);
      }
    }
  }
  return {};
}

/// The 8 bytes in front.
inline std::optional<SizeError> check_fingerprint(const Type& type, std::span<const std::byte> m) {
  if (m.size() < 8) return SizeError{0, "", std::to_string(m.size()) + " bytes are no message"};
  if (std::int64_t(big_endian(m.data(), 8)) == type.fingerprint) return {};
  const Type* other = Schema::builtin().type_of(m);
  return SizeError{0, "",
                   "fingerprint is not " + type.name + "'s" + (other ? " but " + other->name + "'s" : "")};
}

/// Members, nothing behind.
template <class Sink>
std::optional<SizeError> walk_members(const Type& type, std::span<const std::byte> m, Sink& sink) {
  std::size_t at = std::min<std::size_t>(8, m.size());
  if (auto e = walk(type, m, at, sink)) return e;
  if (at != m.size() && !sink.stop)
    return SizeError{at, "", std::to_string(m.size() - at) + " bytes stand behind the last member"};
  return {};
}

/// Fingerprint, members, nothing behind.
template <class Sink>
std::optional<SizeError> walk_message(const Type& type, std::span<const std::byte> m, Sink& sink) {
  if (auto e = check_fingerprint(type, m)) return e;
  return walk_members(type, m, sink);
}

}  // namespace firn::schema
