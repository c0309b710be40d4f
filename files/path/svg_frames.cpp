#include "files/path/svg_frames.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "files/lowercase.h"
#include "files/path/svg_scanner.h"
#include "files/path/svg_shapes.h"
#include "files/trimmed.h"

namespace firn::svg {
namespace {

constexpr double kTurn_deg = 360.0;

struct UnitName {
  std::string_view name;
  double factor;  ///< mm; 0 of a relative unit
};
constexpr UnitName kLengthUnits[] = {{"px", kPixel_mm}, {"mm", 1.0},         {"cm", 10.0},       {"q", 0.25},
                                     {"in", 25.4},      {"pt", 25.4 / 72.0}, {"pc", 25.4 / 6.0}, {"em", 0.0},
                                     {"rem", 0.0},      {"ex", 0.0},         {"ch", 0.0},        {"vw", 0.0},
                                     {"vh", 0.0},       {"vmin", 0.0},       {"vmax", 0.0}};

/// Reads a length where others may follow.
Length next_length(Scanner& text, bool is_css) {
  Length out;
  out.value = text.number();
  if (text.take('%')) {
    out.unit = Length::Unit::kPercent;
    return out;
  }
  const std::string unit = lowercase(text.unit());
  if (unit.empty()) {
    if (is_css && out.value != 0.0) text.fail("in a style a length needs its unit, as px");
    return out;
  }
  for (const UnitName& known : kLengthUnits) {
    if (known.name != unit) continue;
    out.unit = known.factor > 0.0 ? Length::Unit::kMillimetre : Length::Unit::kRelative;
    if (known.factor > 0.0) out.value *= known.factor;
    return out;
  }
  text.fail(fmt::format("a length in mm, cm, in, pt, pc, px or % is needed, not in '{}'", unit));
}

/// Reads an angle [degrees].
double next_angle(Scanner& text, bool is_css) {
  const double value = text.number();
  const std::string unit = lowercase(text.unit());
  if (unit == "deg") return value;
  if (unit == "rad") return value * 180.0 / std::numbers::pi;
  if (unit == "grad") return value * 0.9;
  if (unit == "turn") return value * kTurn_deg;
  if (unit.empty() && (!is_css || value == 0.0)) return value;
  text.fail("in a style an angle needs its unit: deg, rad, grad or turn");
}

PlaneTransform skew(double x_deg, double y_deg) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  return {1.0, std::tan(y_deg * kDegree), std::tan(x_deg * kDegree), 1.0, 0.0, 0.0};
}

/// Reads one function of a transform, behind its name and bracket.
PlaneTransform one_transform(const std::string& name, Scanner& text, bool is_css, const Viewport& viewport) {
  std::array<double, 6> v{};
  std::size_t n = 0;
  constexpr std::array<std::string_view, 11> kKnown{"matrix", "translate", "translatex", "translatey",
                                                    "scale",  "scalex",    "scaley",     "rotate",
                                                    "skew",   "skewx",     "skewy"};
  if (std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end())
    text.fail(fmt::format("transform: '{}' is not read", name.substr(0, 20)));
  const bool turns = name.starts_with("rotate") || name.starts_with("skew");
  const bool moves = name.starts_with("translate");
  while (text.at_number()) {
    if (n == v.size()) text.fail("transform: at most 6 numbers");
    const bool down = name == "translatey" || (name == "translate" && n == 1);
    if (moves)
      v[n] = is_css ? next_length(text, true).user(down ? viewport.height : viewport.width) : text.number();
    else
      v[n] = turns && (n == 0 || name == "skew") ? next_angle(text, is_css) : text.number();
    ++n;
    text.skip_separator();
  }
  if (!text.take(')')) text.fail("transform: a number or a ) is needed");
  if (name == "matrix" && n == 6) return {v[0], v[1], v[2], v[3], v[4], v[5]};
  if (name == "translate" && (n == 1 || n == 2)) return PlaneTransform::translation(v[0], v[1]);
  if (name == "scale" && (n == 1 || n == 2)) return PlaneTransform::scaling(v[0], v[n - 1]);
  if (name == "rotate" && n == 1) return PlaneTransform::rotation_deg(v[0]);
  if (name == "rotate" && n == 3 && !is_css)
    return PlaneTransform::translation(v[1], v[2]) * PlaneTransform::rotation_deg(v[0]) *
           PlaneTransform::translation(-v[1], -v[2]);
  if (name == "skewx" && n == 1) return skew(v[0], 0.0);
  if (name == "skewy" && n == 1) return skew(0.0, v[0]);
  if (is_css && name == "skew" && (n == 1 || n == 2)) return skew(v[0], v[1]);
  if (is_css && name == "translatex" && n == 1) return PlaneTransform::translation(v[0], 0.0);
  if (is_css && name == "translatey" && n == 1) return PlaneTransform::translation(0.0, v[0]);
  if (is_css && name == "scalex" && n == 1) return PlaneTransform::scaling(v[0], 1.0);
  if (is_css && name == "scaley" && n == 1) return PlaneTransform::scaling(1.0, v[0]);
  text.fail(fmt::format("transform: '{}' with {} numbers is not known", name.substr(0, 20), n));
}

PlaneTransform functions(const Value& value, const Viewport& viewport) {
  Scanner text(value.text);
  PlaneTransform all;
  if (lowercase(value.text) == "none") return all;
  while (!text.empty()) {
    const std::string name = lowercase(text.word());
    text.skip_blanks();
    if (!text.take('(')) text.fail("transform: a function such as rotate( is needed");
    all = all * one_transform(name, text, value.is_css, viewport);
    text.skip_separator();
  }
  return all;
}

/// The point that an element's transform leaves in place: 0, 0, or such as "center" and "20px 10%".
Point2 origin(const Value& value, const Viewport& viewport) {
  Scanner text(value.text);
  std::vector<std::optional<Length>> places;  // absent: center
  bool down_first = false;
  for (; !text.empty(); text.skip_separator()) {
    if (text.at_number()) {
      places.emplace_back(next_length(text, value.is_css));
      continue;
    }
    const std::string word = lowercase(text.word());
    if (word == "top" || word == "bottom") down_first = down_first || places.empty();
    if (word == "left" || word == "top")
      places.emplace_back(Length{0.0, Length::Unit::kPercent});
    else if (word == "right" || word == "bottom")
      places.emplace_back(Length{100.0, Length::Unit::kPercent});
    else if (word == "center")
      places.emplace_back(std::nullopt);
    else
      text.fail("transform-origin: lengths, or left, center, right, top, bottom are needed");
  }
  if (places.empty() || places.size() > 3) text.fail("transform-origin: two lengths are needed");
  if (places.size() == 1) places.emplace_back(std::nullopt);
  if (down_first) std::swap(places[0], places[1]);
  const Length middle{50.0, Length::Unit::kPercent};
  return {places[0].value_or(middle).user(viewport.width), places[1].value_or(middle).user(viewport.height)};
}

}  // namespace

std::optional<double> Viewport::diagonal() const {
  if (!width || !height) return std::nullopt;
  return std::sqrt(0.5 * (*width * *width + *height * *height));
}

double Length::user(std::optional<double> whole) const {
  switch (unit) {
    case Unit::kNone:
      return value;
    case Unit::kMillimetre:
      return value / kPixel_mm;
    case Unit::kPercent:
      if (!whole)
        throw SyntaxError(fmt::format("{}% of a page without a size: give the svg a viewBox", value));
      return 0.01 * value * *whole;
    case Unit::kRelative:
      break;
  }
  throw SyntaxError("a length in em, rem, ex, ch, vw, vh, vmin or vmax is not read: give it in mm or px");
}

Length length(const Value& value) {
  try {
    Scanner text(value.text);
    const Length out = next_length(text, value.is_css);
    if (!text.empty()) text.fail("a length in mm, cm, in, pt, pc, px or % is needed");
    return out;
  } catch (const SyntaxError& e) {
    throw SyntaxError(fmt::format("\"{}\": {}", value.text.substr(0, 40), e.what()));
  }
}

void numbers(std::string_view attribute, std::span<double> out) {
  Scanner text(attribute);
  for (double& value : out) value = text.next();
  if (!text.empty()) text.fail(fmt::format("{} numbers are needed", out.size()));
}

PlaneTransform transform(const Properties& properties, const Viewport& viewport) {
  for (const char* other : {"translate", "rotate", "scale", "offset", "offset-path"})
    if (const Value* const value = properties.find(other); value && lowercase(value->text) != "none")
      throw SyntaxError(fmt::format("style: {} is not read: use transform", other));
  const Value* const value = properties.find("transform");
  if (value == nullptr || lowercase(value->text) == "none") return {};
  if (const Value* const box = properties.find("transform-box"); box && lowercase(box->text) != "view-box")
    throw SyntaxError(
        fmt::format("transform-box = {} is not read: it must be view-box", box->text.substr(0, 40)));
  const PlaneTransform all = functions(*value, viewport);
  const Value* const about = properties.find("transform-origin");
  if (about == nullptr) return all;
  const Point2 fixed = origin(*about, viewport);
  return PlaneTransform::translation(fixed.x_mm, fixed.y_mm) * all *
         PlaneTransform::translation(-fixed.x_mm, -fixed.y_mm);
}

PlaneTransform fit(std::span<const double, 4> box, double width, double height, std::string_view how) {
  const double wide = width / box[2], high = height / box[3];
  const auto word = [&] {
    how = trimmed(how);
    const std::string_view one = how.substr(0, how.find_first_of(" \t\r\n"));
    how.remove_prefix(one.size());
    return one;
  };
  std::string_view align = word();
  if (align.empty()) align = "xMidYMid";
  if (align == "none") return {wide, 0.0, 0.0, high, -wide * box[0], -high * box[1]};
  const auto share = [&](std::string_view text) {
    return text == "Min" ? 0.0 : text == "Mid" ? 0.5 : text == "Max" ? 1.0 : -1.0;
  };
  const double x = align.size() == 8 && align[0] == 'x' ? share(align.substr(1, 3)) : -1.0,
               y = align.size() == 8 && align[4] == 'Y' ? share(align.substr(5)) : -1.0;
  const std::string_view size = word();
  if (x < 0.0 || y < 0.0 || (!size.empty() && size != "meet" && size != "slice"))
    throw SyntaxError("preserveAspectRatio: none, or such as xMidYMid, then meet or slice");
  const double scale = size == "slice" ? std::max(wide, high) : std::min(wide, high);
  const double left = scale == wide ? 0.0 : x * (width - scale * box[2]),
               top = scale == high ? 0.0 : y * (height - scale * box[3]);
  return {scale, 0.0, 0.0, scale, left - scale * box[0], top - scale * box[1]};
}

}  // namespace firn::svg
