// base64 returns bytes as text of the alphabet of RFC 4648, section 4, with padding.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace firn {

std::string base64(std::span<const std::byte> bytes);

}  // namespace firn
