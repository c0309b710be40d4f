// csv_text quotes a text for a CSV file (RFC 4180).
#pragma once

#include <string>
#include <string_view>

namespace firn::report {

std::string csv_text(std::string_view text);

}  // namespace firn::report
