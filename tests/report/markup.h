// Reads back the SVG, HTML, PNG and CSV that a report consists of, with code that shares nothing with the
// code that writes them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace firn::test {

/// One element of a parsed page. `text` is the text directly inside it, entities decoded.
struct Element {
  std::string name, text;
  std::map<std::string, std::string> attributes;
  std::vector<Element> children;

  /// The value of an attribute, "" without it.
  std::string attribute(const std::string& key) const;
  /// A numeric attribute. @throws std::runtime_error: missing, or not a finite number
  double at(const std::string& key) const;
  /// All text inside, that of descendants included.
  std::string all_text() const;
  /// Descendants of a name, in document order, optionally with one attribute of a given value.
  std::vector<const Element*> all(const std::string& name, const std::string& key = "",
                                  const std::string& value = "") const;
  /// The only descendant of that kind. @throws std::runtime_error: none, or several
  const Element& only(const std::string& name, const std::string& key = "",
                      const std::string& value = "") const;
};

/// Parses a page or a drawing strictly; the root has the name "". @throws std::runtime_error with the byte:
/// unbalanced or unknown structure, attributes without quotes or given twice, bare < or &, invalid UTF-8.
Element parse_markup(std::string_view text);

struct PixelPoint {
  double x = 0.0, y = 0.0;
};
/// Polylines of a path's `d` with M, L, H, V, v, h, l and Z. @throws std::runtime_error: any other letter, or
/// a number that is not finite
std::vector<std::vector<PixelPoint>> polylines_of(const std::string& d);

/// One axis as a reader of the picture knows it: values of pixels by interpolation between its tick texts.
class ReadAxis {
 public:
  ReadAxis(std::vector<double> px, std::vector<double> values, bool logarithmic);
  double value(double px) const;
  double per_px(double px) const;  ///< size of a pixel in units of the axis there
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> px_, values_;
  bool logarithmic_;
};
/// From the tick texts of a drawing of axes: x ticks are centred below, y ticks end left of the axis.
ReadAxis x_axis_of(const Element& svg);
ReadAxis y_axis_of(const Element& svg, bool logarithmic = false);

struct ReadPicture {
  int width = 0, height = 0;
  std::vector<std::array<std::uint8_t, 4>> pixels;  ///< rows from the top; red, green, blue, alpha
  std::array<std::uint8_t, 4> at(int x, int y) const { return pixels.at(std::size_t(y * width + x)); }
};
ReadPicture picture_of(std::string_view png_bytes);
/// The pixels of an <image> element, read by libpng.
ReadPicture picture_of(const Element& image);

/// Rows and cells of CSV text [RFC 4180]. @throws std::runtime_error: a quote out of place, or rows of
/// different length
std::vector<std::vector<std::string>> csv_rows(const std::string& text);

/// Rows of an HTML table as text.
std::vector<std::vector<std::string>> table_rows(const Element& table);

/// A number as it is printed in a picture or a table: true minus sign, thousands without separator.
/// @throws std::runtime_error: no number
double printed_number(std::string text);

}  // namespace firn::test
