#include "config/text_limits.h"

#include <algorithm>

#include "config/error.h"

namespace firn {

void check_text(std::string_view text, const std::string& file) {
  // A configuration is a page of text.
  constexpr std::size_t kMaxBytes = 65536, kMaxLine = 2000, kMaxDots = 4000;
  if (text.size() > kMaxBytes)
    throw ConfigError(
        file, 0, "",
        std::to_string(text.size()) + " bytes is above the limit of " + std::to_string(kMaxBytes));
  if (std::size_t(std::count(text.begin(), text.end(), '.')) > kMaxDots)
    throw ConfigError(file, 0, "", "more than " + std::to_string(kMaxDots) + " dots: too deeply nested");
  std::size_t length = 0;
  int line = 1;
  for (char c : text) {
    if (c == '\n') ++line;
    length = c == '\n' ? 0 : length + 1;
    if (length > kMaxLine)
      throw ConfigError(file, line, "",
                        "a line longer than the limit of " + std::to_string(kMaxLine) + " bytes");
  }
}

}  // namespace firn
