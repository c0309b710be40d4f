#include "files/path/gcode_survey.h"

#include <algorithm>

#include "files/text_lines.h"

namespace firn {
namespace {

/// Codes whose words are no coordinates of a move.
bool moves(const GcodeBlock& b) {
  const bool coordinates = b['X'] || b['Y'] || b['I'] || b['J'] || b['R'];
  return coordinates && std::ranges::none_of(b.g, [](double g) {
           return g == 4.0 || g == 10.0 || g == 28.0 || g == 30.0 || (g >= 92.0 && g < 93.0);
         });
}

}  // namespace

GcodeSurvey survey_gcode(std::istream& in, const std::string& name) {
  TextLines lines(in, name, kMaxGcodeLineBytes);
  GcodeSurvey s;
  bool axis_e = false, moved_e = false, dark = false, bright = false, begun = false;
  std::string_view line;
  while (lines.next(line)) {
    const GcodeBlock b = read_gcode_block(line, GcodeExponent::kUnknown,
                                          [&](const std::string& problem) { lines.fail(problem); });
    if (b.percent && begun) break;
    begun = begun || !b.empty;
    axis_e = axis_e || b.e_axis || b.has_m(82.0) || b.has_m(83.0);
    moved_e = moved_e || (b['E'] && moves(b));
    s.switched = s.switched || b.has_m(3.0) || b.has_m(4.0);
    if (b['S'] && !b.has_g(4.0)) {
      s.has_power = true;
      if (moves(b)) (*b['S'] > 0.0 ? bright : dark) = true;
    }
    s.decimals = std::max(s.decimals, b.decimals);
    if (b.has_m(2.0) || b.has_m(30.0) || b.has_m(99.0)) break;
  }
  if (axis_e) s.exponent = GcodeExponent::kWordE;
  if (axis_e && moved_e)
    s.material = GcodeSurvey::Material::kExtruder;
  else if (s.switched || (dark && bright))
    s.material = GcodeSurvey::Material::kBeam;
  return s;
}

}  // namespace firn
