// check_text checks the size, line length and nesting of a TOML text before it is parsed.
#pragma once

#include <string>
#include <string_view>

namespace firn {

/// Bounds any TOML text, so that its nesting, and the parser's stack, stay small.
/// @throws ConfigError naming the limit
void check_text(std::string_view text, const std::string& file);

}  // namespace firn
