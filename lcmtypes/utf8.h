// utf8_length and valid_utf8 judge and mend text that may not be UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace firn {

/// Returns the length of the UTF-8 sequence at the front of `text`, 0 if it is none (RFC 3629).
std::size_t utf8_length(std::string_view text);

/// Returns the text with each byte that is not UTF-8, and each zero byte, as U+FFFD.
std::string valid_utf8(std::string_view text);

}  // namespace firn
