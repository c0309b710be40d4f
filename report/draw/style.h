// Holds the style sheet of pages and pictures.
#pragma once

#include <string>

namespace firn::report {

/// Holds the CSS of all pages and pictures: the classes and colours that the drawing functions use.
extern const char* const kReportStyle;

/// Returns one <svg> with the style sheet inside, so that it can be viewed alone.
std::string standalone_svg(std::string svg);

}  // namespace firn::report
