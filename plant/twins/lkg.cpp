#include "plant/twins/lkg.h"

#include <cmath>

namespace firn::plant::lkg {

std::string refused(std::string_view line, Error error) {
  const bool setting = (line.starts_with("SW,") || line.starts_with("SR,")) && line.size() >= 5;
  const int code = int(error);
  return "ER," + std::string(line.substr(setting ? 3 : 0, 2)) + ',' + char('0' + code / 10) +
         char('0' + code % 10);
}

std::string value(double mm) {
  if (std::isnan(mm)) return "XXXXXXXX";
  const char sign = mm < 0.0 ? '-' : '+';
  const double counts = std::round(std::abs(mm) * 1e4);
  if (counts > 999'999.0) return sign + std::string("FFFFFFF");
  std::string digits = std::to_string(1'000'000 + std::int32_t(counts)).substr(1);
  return sign + digits.insert(2, ".");
}

}  // namespace firn::plant::lkg
