// Sha256 and sha256_hex compute the SHA-256 digest of bytes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace firn {

/// Computes the digest of bytes that come in parts (OpenSSL).
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(std::span<const std::byte> bytes);
  /// Returns the digest of all bytes so far; more bytes may follow.
  std::array<std::byte, 32> bytes() const;
  /// Returns the digest of all bytes so far as 64 lower-case hex digits.
  std::string hex() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the SHA-256 digest as 64 lower-case hex digits.
std::string sha256_hex(std::span<const std::byte> bytes);
/// Returns true for 64 lower-case hex digits.
bool is_sha256_hex(std::string_view text);

}  // namespace firn
