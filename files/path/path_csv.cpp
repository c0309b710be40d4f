// Reads paths from CSV: a row for each point, a blank line between paths.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "files/path/csv_columns.h"
#include "files/path/path_file.h"
#include "files/separated_values.h"

namespace firn {
namespace {

constexpr std::size_t kMaxLineBytes = 1000;

class CsvReader {
 public:
  CsvReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in, name, kMaxLineBytes), name_(name), size_(size), sink_(sink) {}

  void read() {
    SeparatedRow row;
    while (in_.next(row)) {
      line_ = row.line;
      if (row.blank())
        finish();
      else if (!columns_.empty() || !header(row))
        point(row);
    }
    if (columns_.empty()) fail(fmt::format("is empty: the first line must be {}", kCsvHeaders));
    finish();
    if (number_ == 0) fail("holds no points");
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { in_.fail(line_, problem); }

  /// Returns true if the row names the columns, false if it is a point of a file without a header.
  bool header(const SeparatedRow& row) {
    const std::function<void(const std::string&)> refuse = [this](const std::string& problem) {
      fail(problem);
    };
    const auto is_value = [this](const std::string& field) { return in_.is_value(field); };
    const bool named = !std::ranges::all_of(row.fields, is_value);
    const bool numbered =
        row.fields.front().empty() && std::all_of(row.fields.begin() + 1, row.fields.end(), is_value);
    if (numbered)
      fail(
          "the first line numbers the columns and the first column the rows, as pandas' to_csv does: name "
          "the "
          "columns, or write with index=False, header=False");
    if (named) {
      std::vector<std::string> names = row.fields;
      if (names.back().empty()) names.pop_back();  // a separator at the end of each line
      columns_ = csv_columns(names, refuse);
    } else {
      unnamed_ = true;
      columns_ = csv_columns(names_without_header(row), refuse);
    }
    for (const CsvColumn& c : columns_)
      if (c.assumed) {
        sink_.note(name_ + ": column '" + c.name + "' names no unit: lengths are taken as mm");
        break;
      }
    return named;
  }

  /// Those of a comment above the points, if it names as many columns; else x_mm, y_mm and z_mm.
  std::vector<std::string> names_without_header(const SeparatedRow& row) {
    const std::size_t count = row.fields.size() - (row.fields.back().empty() ? 1 : 0);
    const std::vector<std::string> commented = in_.commented_names();
    bool known = commented.size() == count;
    if (known) csv_columns(commented, [&](const std::string&) { known = false; });
    if (known) {
      unnamed_ = false;
      return commented;
    }
    if (count == 2) return {"x_mm", "y_mm"};
    if (count == 3) return {"x_mm", "y_mm", "z_mm"};
    fail(fmt::format(
        "a file without a header has two columns, x_mm and y_mm, or three, with z_mm, not {}; name "
        "these: {}",
        count, kCsvHeaders));
  }

  double within(double value, double most, const std::string& column) const {
    if (std::abs(value) <= most) return value;
    fail(column.empty() ? fmt::format("{} mm is beyond the limit of +-{} mm", value, most)
                        : fmt::format("{} = {} is beyond the limit of +-{}", column, value, most));
  }

  void point(const SeparatedRow& row) {
    const bool trailing = row.fields.size() == columns_.size() + 1 && row.fields.back().empty();
    if (row.fields.size() != columns_.size() && !trailing)
      fail(fmt::format("{} columns, the {} {}{}", row.fields.size(),
                       unnamed_ ? "first line has" : "header has", columns_.size(),
                       row.fields.size() == 2 * columns_.size()
                           ? "; numbers with decimal commas need semicolons, tabs or blanks between them"
                           : ""));
    Point2 p;
    std::optional<double> z_mm, speed_mm_s, yaw_deg;
    for (std::size_t n = 0; n < columns_.size(); ++n) value(row, n, p, z_mm, speed_mm_s, yaw_deg);
    if (path_.path.points.empty()) {
      path_.place = fmt::format("{}:{}", name_, line_);
      path_.path.z_mm = z_mm.value_or(0.0);
    }
    if (z_mm && *z_mm != path_.path.z_mm)
      fail(unnamed_
               ? fmt::format("the third column of a file without a header is z_mm, which must be constant "
                             "along a path; if it is something else, name it: {}",
                             kCsvHeaders)
               : "z changes along a path; it must be constant");
    if (path_.path.points.size() == kMaxPathPoints)
      fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    path_.path.points.push_back(p);
    if (speed_mm_s) path_.speed_limit.point_mm_s.push_back(*speed_mm_s);
    if (yaw_deg) path_.yaw_point_rad.push_back(*yaw_deg * std::numbers::pi / 180.0);
  }

  void value(const SeparatedRow& row, std::size_t n, Point2& p, std::optional<double>& z_mm,
             std::optional<double>& speed_mm_s, std::optional<double>& yaw_deg) {
    using Quantity = CsvColumn::Quantity;
    const CsvColumn& column = columns_[n];
    if (column.quantity == Quantity::kIndex) return;
    if (column.quantity == Quantity::kSpeed && row.fields[n].empty()) {
      speed_mm_s = motion::kUnlimited;
      return;
    }
    const double v = column.scale * in_.finite_number(row, n, column.name);
    switch (column.quantity) {
      case Quantity::kX:
        p.x_mm = within(v, kMaxCoordinate_mm, {});
        break;
      case Quantity::kY:
        p.y_mm = within(v, kMaxCoordinate_mm, {});
        break;
      case Quantity::kZ:
        z_mm = within(v, kMaxCoordinate_mm, {});
        break;
      case Quantity::kSpeed:
        speed_mm_s = v;
        if (!(v > 0.0)) fail(fmt::format("{} must be above 0", column.name));
        break;
      case Quantity::kYaw:
        yaw_deg = within(v, kMaxYaw_deg, column.name);
        break;
      case Quantity::kIndex:
        break;
    }
  }

  void finish() {
    if (path_.path.points.empty()) return;
    path_.number = ++number_;
    path_.fraction = in_.fraction(size_);
    sink_(std::move(path_));
    path_ = InputPath();
  }

  SeparatedValues in_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  InputPath path_;
  std::int64_t number_ = 0, line_ = 1;
  bool unnamed_ = false;  // no header
  std::vector<CsvColumn> columns_;
};

}  // namespace

void read_paths_csv(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  CsvReader(in, name, size, sink).read();
}

}  // namespace firn
