#include "files/path/path_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <optional>

#include "files/byte_blocks.h"
#include "files/decimal.h"
#include "files/path/csv_columns.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMaxLineBytes = 1000;

class CsvReader {
 public:
  CsvReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  void read() {
    std::string_view text;
    while (next_line(text)) {
      if (columns_.empty()) {
        if (!text.empty() && header(text)) point(text);
      } else if (text.empty()) {
        finish();
      } else {
        point(text);
      }
    }
    if (columns_.empty()) fail(fmt::format("is empty: the first line must be {}", kCsvHeaders));
    finish();
    if (number_ == 0) fail("holds no points");
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line_, problem));
  }

  /// Returns the next line, valid until the next call.
  bool next_line(std::string_view& text) {
    in_.take(used_);
    ++line_;
    std::size_t looked = 0;
    const char* end = nullptr;
    while (!end) {
      end = static_cast<const char*>(std::memchr(in_.begin() + looked, '\n', in_.size() - looked));
      looked = in_.size();
      if (end || (looked <= kMaxLineBytes && in_.more())) continue;
      break;
    }
    const std::size_t length = end ? std::size_t(end - in_.begin()) : in_.size();
    used_ = length + (end ? 1 : 0);
    if (used_ == 0) return false;
    if (length > kMaxLineBytes) fail(fmt::format("a line longer than the limit of {} bytes", kMaxLineBytes));
    text = std::string_view(in_.begin(), length);
    if (line_ == 1 && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // as spreadsheets write it
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t'))
      text.remove_suffix(1);
    return true;
  }

  /// Returns true if the line is a point: a file without a header.
  bool header(std::string_view text) {
    constexpr std::string_view kPlain = "x_mm,y_mm", kWithHeight = "x_mm,y_mm,z_mm";
    separator_ = csv_separator(text);
    unnamed_ = csv_numbers(text, separator_);
    const auto separators = std::count(text.begin(), text.end(), separator_);
    header_ = !unnamed_ ? text : separators == 2 ? kWithHeight : kPlain;
    const auto columns = csv_columns(header_, unnamed_ ? ',' : separator_);
    if (!columns) {
      fail(fmt::format("the header must be {}, not {}", kCsvHeaders, shown(text.substr(0, 60))));
    }
    columns_ = *columns;
    if (unnamed_ && separators != 1 && separators != 2)
      fail(
          fmt::format("a file without a header has two columns, x_mm and y_mm, or three, with z_mm; name "
                      "these: {}",
                      kCsvHeaders));
    return unnamed_;
  }

  double number(std::string_view text, std::string_view column) const {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    double value = 0.0;
    const char* const last = text.data() + text.size();
    if (read_short_decimal(text.data(), last, value) == last) return value;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail(fmt::format("{} = {}: is not a finite number", column, shown(text.substr(0, 40))));
    return value;
  }

  static std::string shown(std::string_view text) {
    std::string line(text);
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return line;
  }

  double within(double value, double most, std::string_view column) const {
    if (std::abs(value) <= most) return value;
    fail(column.empty() ? fmt::format("{} mm is beyond the limit of +-{} mm", value, most)
                        : fmt::format("{} = {} is beyond the limit of +-{}", column, value, most));
  }

  void point(std::string_view text) {
    Point2 p;
    std::optional<double> z_mm, speed_mm_s, yaw_deg;
    std::size_t found = 0;
    for (std::size_t from = 0; from != text.npos; ++found) {
      const std::size_t comma = text.find(separator_, from);
      if (found < columns_.size())
        value(columns_[found], text.substr(from, comma == text.npos ? comma : comma - from), p, z_mm,
              speed_mm_s, yaw_deg);
      from = comma == text.npos ? comma : comma + 1;
    }
    if (found != columns_.size()) fail(fmt::format("{} columns, the header has {}", found, columns_.size()));
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

  void value(const CsvColumn& column, std::string_view text, Point2& p, std::optional<double>& z_mm,
             std::optional<double>& speed_mm_s, std::optional<double>& yaw_deg) const {
    using Quantity = CsvColumn::Quantity;
    if (column.quantity == Quantity::kSpeed && text.empty()) {
      speed_mm_s = motion::kUnlimited;
      return;
    }
    const double v = column.scale * number(text, column.name);
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
    }
  }

  void finish() {
    if (path_.path.points.empty()) return;
    path_.number = ++number_;
    path_.fraction = size_ > 0.0 ? double(in_.position() + used_) / size_ : 0.0;
    sink_(std::move(path_));
    path_ = InputPath();
  }

  ByteBlocks in_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  InputPath path_;
  std::int64_t number_ = 0;
  std::size_t used_ = 0;  // bytes of the line that was handed out
  int line_ = 0;
  char separator_ = ',';
  bool unnamed_ = false;  // no header
  std::string header_;    // holds the names of the columns
  std::vector<CsvColumn> columns_;
};

}  // namespace

void read_paths_csv(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  CsvReader(in, name, size, sink).read();
}

void read_paths(const std::filesystem::path& file, const PathSink& sink) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw UsageError(file.string() + ": is a folder, not a file");
  if (!std::filesystem::is_regular_file(file, error)) throw UsageError(file.string() + ": no such file");
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  if (extension == ".paths") return read_paths_layers(file, sink);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw UsageError(file.string() + ": cannot be read");
  const double size = double(std::filesystem::file_size(file, error));
  if (extension == ".csv") return read_paths_csv(in, file.string(), size, sink);
  if (extension == ".json") return read_paths_json(in, file.string(), size, sink);
  if (extension == ".svg") return read_paths_svg(in, file.string(), size, sink);
  if (extension == ".dxf") return read_paths_dxf(in, file.string(), size, sink);
  for (const char* gcode : {".gcode", ".nc", ".ngc", ".g", ".gco", ".cnc", ".tap"})
    if (extension == gcode) return read_paths_gcode(in, file.string(), size, sink);
  throw UsageError(
      file.string() +
      ": must end in .gcode, .nc, .ngc, .g, .gco, .cnc, .tap, .dxf, .svg, .csv, .json or .paths");
}

}  // namespace firn
