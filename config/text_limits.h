#pragma once

#include <string>
#include <string_view>

namespace firn {

/// Bounds on any TOML text, so that its nesting, and with it the parser's stack, stays small.
/// @throws ConfigError naming the limit
void check_text(std::string_view text, const std::string& file);

}  // namespace firn
