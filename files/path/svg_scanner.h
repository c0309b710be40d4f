// svg::Scanner reads an attribute of an SVG file from its front.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/path/path.h"

namespace firn::svg {

class Scanner {
 public:
  explicit Scanner(std::string_view text) : all_(text), rest_(text) {}

  /// @throws SyntaxError naming the place and the text there
  [[noreturn]] void fail(const std::string& problem) const;

  void skip_blanks();
  /// Blanks and at most one comma.
  void skip_separator();
  bool take(char c);
  bool empty();      ///< but for blanks
  bool at_number();  ///< behind blanks
  double number();
  double next();  ///< a number and the comma or blanks after it
  Point2 point();
  bool flag();              ///< 0 or 1
  std::string_view word();  ///< of letters and digits
  std::string_view unit();  ///< letters right behind a number
  char letter();

 private:
  template <class Is>
  std::string_view take_while(Is&& is) {
    std::size_t n = 0;
    while (n < rest_.size() && is(static_cast<unsigned char>(rest_[n]))) ++n;
    const std::string_view found = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return found;
  }

  std::string_view all_, rest_;
};

}  // namespace firn::svg
