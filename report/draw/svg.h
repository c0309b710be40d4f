// Writes small pieces of SVG and HTML: escaped text, numbers, axes with round ticks. Colours are CSS
// variables of the page, so that one drawing is legible on light and on dark.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace firn::report {

std::string escape_html(std::string_view text);
/// Returns a row of a table of HTML. @param tag of its cells: "td", "th"
std::string table_row(const std::vector<std::string>& cells, const char* tag = "td");
/// Returns the beginning of a text: at most so many bytes, and only whole UTF-8 characters.
std::string_view shortened(std::string_view text, std::size_t bytes);
/// Returns the number as "%.*f" without a locale; "–" for NaN and infinities; a true minus sign.
std::string number(double value, int decimals);
/// The same in three significant digits (core/options/for_people.h).
std::string number(double value);

/// Maps data units to pixels on a linear or logarithmic axis, with ticks at round values.
class Axis {
 public:
  enum class Kind { kLinear, kWhole, kLogarithmic };  ///< kWhole: ticks at whole numbers only
  /// Spans exactly [low, high] with about `wanted` ticks inside. A range that is empty, or narrower than
  /// 1e-12 of its values, is widened to a range around its value. kLogarithmic: low > 0.
  Axis(double low, double high, double from_px, double to_px, int wanted, Kind kind = Kind::kLinear);
  double px(double value) const;
  struct Tick {
    double value;
    std::string text;
  };
  const std::vector<Tick>& ticks() const { return ticks_; }
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  double low_, high_, from_px_, to_px_;
  Kind kind_;
  std::vector<Tick> ticks_;
};

/// Holds the plotting area of a chart in pixels.
struct Frame {
  double left = 54, top = 10, right = 414, bottom = 250;
};
/// Draws grid lines, tick texts, and the axes' names with units.
std::string draw_axes(const Frame& frame, const Axis& x, const Axis& y, std::string_view x_name,
                      std::string_view y_name);
/// Returns <text class="cls" …>.
std::string svg_text(double x, double y, std::string_view anchor, std::string_view cls,
                     std::string_view text);
std::string svg_open(double width, double height, std::string_view title);

}  // namespace firn::report
