// Draws line charts and stacked bars as SVG. Lines differ by colour, dashes and marks, so that they are
// distinct without colour too.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace firn::report {

struct Series {
  std::string label;
  std::vector<double> x, y;  ///< NaN breaks the line
  int style = 0;             ///< colour and dashes of run n; kReference = the target
  bool marks = false;
  std::vector<double> low = {},
                      high = {};  ///< of a band about the line; empty, or as many as x; NaN: no band there
  static constexpr int kReference = -1;
};

struct ChartOptions {
  std::string title, x_name, y_name;  ///< names with units
  bool logarithmic = false;           ///< y
  bool whole_x = false;
  bool from_zero = false;  ///< y starts at 0
  std::optional<std::pair<double, double>> y_range = {};
  std::vector<std::pair<double, double>> shaded = {};  ///< spans of x
  std::string shaded_label = {};                       ///< in the legend; empty: no label
  bool legend = true;                                  ///< false: the page has one for all its charts
};
std::string line_chart(const std::vector<Series>& series, const ChartOptions& options);

/// Holds one bar for each x, stacked from the parts.
struct Bars {
  std::vector<double> x;
  std::vector<std::string> parts;            ///< labels
  std::vector<std::vector<double>> heights;  ///< [part][x]
};
/// Draws the bars.
/// @param top the axis' upper end, so that several charts compare
std::string bar_chart(const Bars& bars, double top, const ChartOptions& options);

/// Holds one label of a legend that several charts share.
struct LegendEntry {
  enum class Kind { kLine, kBar };
  std::string label;
  int style = 0;  ///< of the series, or number of the bars' part
  Kind kind = Kind::kLine;
};
/// Returns the sample of a series, or of a part of bars: a small drawing for a line of text.
std::string legend_sample(const LegendEntry& entry);
/// Returns HTML: the samples with their labels.
std::string shared_legend(const std::vector<LegendEntry>& entries);

}  // namespace firn::report
