#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace firn {

/// SHA-256 as 64 lower-case hex digits (OpenSSL).
std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace firn
