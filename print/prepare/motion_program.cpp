#include "print/prepare/motion_program.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace firn {
namespace {

/// As a program holds it: a nanometre.
double rounded(double mm) {
  constexpr double kPerMm = 1e6;
  return std::round(mm * kPerMm) / kPerMm + 0.0;  // no -0
}

/// Nine digits without an exponent, which controllers refuse.
std::string plain(double value) {
  constexpr int kDecimals = 15;
  std::string text = fmt::format("{:.9g}", value);
  if (text.find('e') == std::string::npos) return text;
  text = fmt::format("{:.{}f}", value, value < 1.0 ? kDecimals : 0);
  if (text.find('.') != std::string::npos) text.erase(text.find_last_not_of('0') + 1);
  return text;
}

}  // namespace

std::string gcode_head(const std::string& machine, const std::string& method) {
  std::string name = machine;
  for (char& c : name)
    if (c == '(' || c == ')' || c < ' ' || c > '~') c = '_';
  return fmt::format("(firn plan, machine {}, method {}: a block a tick)\nG17 G21 G90 G94\n", name, method);
}

std::string gcode_lines(const PlannedItem& item) {
  const std::vector<Point2>& tool = item.result.tool;
  const double tick_s = item.result.trajectory.tick_s;
  fmt::memory_buffer lines;
  const auto out = std::back_inserter(lines);
  fmt::format_to(out, "(path {})\n", item.input.number);
  if (tool.empty()) return fmt::to_string(lines);
  Point2 at{rounded(tool[0].x_mm), rounded(tool[0].y_mm)};
  fmt::format_to(out, "G0 X{:.6f} Y{:.6f}", at.x_mm, at.y_mm);
  if (item.input.path.z_mm != 0.0) fmt::format_to(out, " Z{:.6f}", item.input.path.z_mm);
  fmt::format_to(out, "\n");
  for (std::size_t n = 1; n < tool.size(); ++n) {
    const Point2 next{rounded(tool[n].x_mm), rounded(tool[n].y_mm)};
    const double chord = distance(at, next);
    if (chord > 0.0)
      fmt::format_to(out, "G1 X{:.6f} Y{:.6f} F{}\n", next.x_mm, next.y_mm, plain(60.0 * chord / tick_s));
    else
      fmt::format_to(out, "G4 P{}\n", plain(tick_s));
    at = next;
  }
  return fmt::to_string(lines);
}

std::string gcode_tail() { return "M2\n"; }

std::string pvt_lines(const PlannedItem& item, const std::vector<std::string>& axes) {
  const Trajectory& t = item.result.trajectory;
  const std::vector<double>& rates = item.result.axis_rates;
  fmt::memory_buffer lines;
  const auto out = std::back_inserter(lines);
  fmt::format_to(out, "' path {}\nLINEAR", item.input.number);
  const std::size_t count = axes.size();
  for (std::size_t a = 0; a < count; ++a) fmt::format_to(out, " {}{:.9f}", axes[a], t.positions[a]);
  fmt::format_to(out, "\nWAIT MOVEDONE");
  for (const std::string& axis : axes) fmt::format_to(out, " {}", axis);
  fmt::format_to(out, "\nPVT INIT TIME ABS\n");
  for (std::size_t n = 1; n < t.samples(); ++n) {
    fmt::format_to(out, "PVT");
    for (std::size_t a = 0; a < count; ++a)
      fmt::format_to(out, " {}{:.9f},{:.9f}", axes[a], t.positions[n * count + a], rates[n * count + a]);
    fmt::format_to(out, " TIME {}\n", plain(double(n) * t.tick_s));
  }
  return fmt::to_string(lines);
}

}  // namespace firn
