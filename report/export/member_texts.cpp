#include "report/export/member_texts.h"

#include <algorithm>
#include <array>
#include <utility>

namespace firn::report {

MemberText member_text(std::string_view type, std::string_view member) {
  const auto row = std::ranges::find_if(
      member_texts(), [&](const MemberText& m) { return m.type == type && m.member == member; });
  return row == member_texts().end() ? MemberText() : *row;
}

std::string_view type_text(std::string_view type) {
  const auto row = std::ranges::find(type_texts(), type, &TypeText::type);
  return row == type_texts().end() ? "" : row->text;
}

std::string unit_of(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 24> kUnits{{
      {"_mm3_s", "mm^3/s"}, {"_mm_s3", "mm/s^3"}, {"_mm_s2", "mm/s^2"}, {"_mm_s", "mm/s"},   {"_mm3", "mm^3"},
      {"_mm2", "mm^2"},     {"_mm", "mm"},        {"_um", "um"},        {"_us", "us"},       {"_ns", "ns"},
      {"_ms", "ms"},        {"_s", "s"},          {"_hz", "Hz"},        {"_rad_s", "rad/s"}, {"_rad", "rad"},
      {"_deg_s", "deg/s"},  {"_deg", "deg"},      {"_degc", "degC"},    {"_c", "degC"},      {"_w", "W"},
      {"_v", "V"},          {"_pct", "%"},        {"_bytes", "byte"},   {"_pa", "Pa"},
  }};
  std::string_view best, unit = "1";
  for (const auto& [ending, means] : kUnits)
    if (name.ends_with(ending) && ending.size() > best.size()) {
      best = ending;
      unit = means;
    }
  return std::string(unit);
}

}  // namespace firn::report
