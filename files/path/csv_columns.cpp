#include "files/path/csv_columns.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "files/column_heading.h"
#include "files/text_lines.h"

namespace firn {
namespace {

using Quantity = CsvColumn::Quantity;

constexpr std::array<std::pair<std::string_view, Quantity>, 5> kQuantities{{{"x", Quantity::kX},
                                                                            {"y", Quantity::kY},
                                                                            {"z", Quantity::kZ},
                                                                            {"speed", Quantity::kSpeed},
                                                                            {"yaw", Quantity::kYaw}}};

std::optional<double> scale_of(Quantity quantity, const std::string& unit) {
  if (quantity == Quantity::kSpeed) return speed_unit_mm_s(unit);
  if (quantity == Quantity::kYaw) {
    if (unit == "deg") return 1.0;
    if (unit == "rad") return 180.0 / std::numbers::pi;
    return std::nullopt;
  }
  return length_unit_mm(unit);
}

const char* units_of(Quantity quantity) {
  if (quantity == Quantity::kSpeed) return "mm_s, mm_min, um_s, ...";
  return quantity == Quantity::kYaw ? "deg, rad" : kLengthUnits;
}

}  // namespace

std::vector<CsvColumn> csv_columns(const std::vector<std::string>& names,
                                   const std::function<void(const std::string&)>& fail) {
  std::vector<CsvColumn> columns;
  for (const std::string& name : names) {
    const std::string shown = shown_text(name, 60);
    const ColumnHeading heading = heading_of(name);
    if (columns.empty() && (name.empty() || heading.word.starts_with("unnamed: 0"))) {
      columns.push_back({Quantity::kIndex, name});
      continue;
    }
    const auto known =
        std::ranges::find(kQuantities, heading.word, &std::pair<std::string_view, Quantity>::first);
    if (known == kQuantities.end()) {
      fail(fmt::format("the header must be {}; column '{}' is not known", kCsvHeaders, shown));
      continue;
    }
    CsvColumn column{known->second, name};
    const bool length = column.quantity != Quantity::kSpeed && column.quantity != Quantity::kYaw;
    column.assumed = length && heading.unit.empty();
    const auto scale = column.assumed ? std::optional(1.0) : scale_of(column.quantity, heading.unit);
    if (!scale)
      fail(fmt::format("the header must be {}; column '{}' names {}: there are {}", kCsvHeaders, shown,
                       heading.unit.empty() ? "no unit" : "an unknown unit", units_of(column.quantity)));
    column.scale = scale.value_or(1.0);
    const auto same = std::ranges::find(columns, column.quantity, &CsvColumn::quantity);
    if (same != columns.end())
      fail(fmt::format("the header must be {}; columns '{}' and '{}' are both {}", kCsvHeaders,
                       shown_text(same->name, 60), shown, known->first));
    columns.push_back(std::move(column));
  }
  for (const Quantity needed : {Quantity::kX, Quantity::kY})
    if (std::ranges::find(columns, needed, &CsvColumn::quantity) == columns.end())
      fail(fmt::format("the header must be {}; there is no column {}", kCsvHeaders,
                       needed == Quantity::kX ? "x" : "y"));
  return columns;
}

}  // namespace firn
