// sha256_hex computes the SHA-256 digest of bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace firn {

/// Returns the SHA-256 digest as 64 lower-case hex digits (OpenSSL).
std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace firn
