// ByteWriter and ByteReader write and read the little-endian bytes of Firn's binary formats. The reader
// checks every limit.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

static_assert(std::endian::native == std::endian::little, "files are written little endian");

/// Error of bytes that cannot be read: what() = "byte <offset>: <the fault, with the limit>".
struct FormatError : std::runtime_error {
  FormatError(std::size_t at, const std::string& what_is_wrong)
      : std::runtime_error("byte " + std::to_string(at) + ": " + what_is_wrong),
        offset(at),
        problem(what_is_wrong) {}
  std::size_t offset;
  std::string problem;  ///< the message without the place
};

inline constexpr std::size_t kMaxNameBytes = 200;

class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), p, p + sizeof value);
  }
  /// u16 length and at most kMaxNameBytes bytes.
  void put_text(const std::string& text) {
    const std::size_t n = std::min(text.size(), kMaxNameBytes);
    put(std::uint16_t(n));
    put_bytes(text.data(), n);
  }
  void put_bytes(const void* data, std::size_t n) {
    const auto* p = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), p, p + n);
  }
  /// Seven bits a byte, lowest first; the top bit says that more follow.
  void put_varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(std::byte(value | 0x80));
    bytes_.push_back(std::byte(value));
  }
  /// Every stride-th of n numbers.
  void put_numbers(const double* from, std::size_t n, std::size_t stride) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + n * sizeof(double));
    std::byte* to = bytes_.data() + at;
    for (std::size_t i = 0; i < n; ++i)
      std::memcpy(to + i * sizeof(double), from + i * stride, sizeof(double));
  }
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[noreturn]] void fail(const std::string& problem) const { throw FormatError(at_, problem); }
  std::size_t left() const { return bytes_.size() - at_; }

  template <class T>
  T get(const char* what) {
    if (left() < sizeof(T)) fail(std::string("ends before ") + what);
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  double get_number(const char* what, double low = -1e12, double high = 1e12) {
    const double value = get<double>(what);
    if (!(value >= low && value <= high)) {
      at_ -= sizeof value;
      fail(std::string(what) + " is not a number between " + std::to_string(low) + " and " +
           std::to_string(high));
    }
    return value;
  }
  std::size_t get_count(const char* what, std::size_t limit) {
    const std::size_t n = get<std::uint32_t>(what);
    if (n <= limit) return n;
    at_ -= sizeof(std::uint32_t);
    fail(std::string(what) + " = " + std::to_string(n) + " is above the limit of " + std::to_string(limit));
  }
  std::string get_text(const char* what) {
    const std::size_t n = get<std::uint16_t>(what);
    if (n > kMaxNameBytes)
      fail(std::string(what) + " is longer than the limit of " + std::to_string(kMaxNameBytes) + " bytes");
    return get_bytes(n, what);
  }
  std::string get_bytes(std::size_t n, const char* what) {
    need(n, what);
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_), n);
    at_ += n;
    return text;
  }
  std::uint64_t get_varint(const char* what) {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      if (at_ == bytes_.size()) fail(std::string("ends within ") + what);
      const auto b = std::uint64_t(bytes_[at_++]);
      if (shift == 63 && b > 1) fail(std::string(what) + " is longer than 64 bits");
      value |= (b & 0x7f) << shift;
      if (b < 0x80) return value;
    }
  }
  std::int64_t get_signed(const char* what) {
    const std::uint64_t value = get_varint(what);
    return std::int64_t(value >> 1) ^ -std::int64_t(value & 1);
  }
  void need(std::size_t bytes, const char* what) const {
    if (left() < bytes) fail(std::string("ends within ") + what);
  }
  void end() const {
    if (left() > 0) fail(std::to_string(left()) + " bytes are left over");
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

}  // namespace firn
