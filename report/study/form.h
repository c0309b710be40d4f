// form() writes numbers into a piece of SVG or text, as printf does.
#pragma once

#include <cstdio>
#include <string>

namespace firn::report {

std::string form(const char* format, auto... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace firn::report
