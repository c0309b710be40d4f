#include "files/path/path_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>

#include "files/byte_blocks.h"
#include "files/decimal.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMaxLineBytes = 1000;
constexpr const char* kHeaders = "x_mm,y_mm with or without ,speed_mm_s and ,yaw_deg";
constexpr int kMostColumns = 4;

class CsvReader {
 public:
  CsvReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  void read() {
    std::string_view text;
    while (next_line(text)) {
      if (columns_ == 0) {
        if (!text.empty()) header(text);
      } else if (text.empty()) {
        finish();
      } else {
        point(text);
      }
    }
    if (columns_ == 0) fail(std::string("is empty: the first line must be ") + kHeaders);
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

  void header(std::string_view text) {
    const std::string_view all = text;
    bool known = text.starts_with("x_mm,y_mm");
    if (known) text.remove_prefix(9);
    columns_ = 2;
    if (text.starts_with(",speed_mm_s")) {
      text.remove_prefix(11);
      speed_ = columns_++;
    }
    if (text.starts_with(",yaw_deg")) {
      text.remove_prefix(8);
      yaw_ = columns_++;
    }
    known = known && text.empty();
    if (known) return;
    std::string shown(all.substr(0, 60));
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    fail(std::string("the header must be ") + kHeaders + ", not " + shown);
  }

  double number(std::string_view text, const char* column) const {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    double value = 0.0;
    const char* const last = text.data() + text.size();
    if (read_short_decimal(text.data(), last, value) == last) return value;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail(fmt::format("{} = {}: is not a finite number", column, text.substr(0, 40)));
    return value;
  }

  void point(std::string_view text) {
    std::array<std::string_view, kMostColumns> column;
    int found = 0;
    for (std::size_t from = 0; from != text.npos; ++found) {
      const std::size_t comma = text.find(',', from);
      if (found < kMostColumns)
        column[std::size_t(found)] = text.substr(from, comma == text.npos ? comma : comma - from);
      from = comma == text.npos ? comma : comma + 1;
    }
    if (found != columns_) fail(fmt::format("{} columns, the header has {}", found, columns_));
    const Point2 p{number(column[0], "x_mm"), number(column[1], "y_mm")};
    for (double v : {p.x_mm, p.y_mm})
      if (std::abs(v) > kMaxCoordinate_mm)
        fail(fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
    if (path_.path.points.empty()) path_.place = fmt::format("{}:{}", name_, line_);
    if (path_.path.points.size() == kMaxPathPoints)
      fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    path_.path.points.push_back(p);
    if (speed_ > 0) {
      const std::string_view speed = column[std::size_t(speed_)];
      path_.speed_limit.point_mm_s.push_back(speed.empty() ? motion::kUnlimited
                                                           : number(speed, "speed_mm_s"));
      if (!(path_.speed_limit.point_mm_s.back() > 0.0)) fail("speed_mm_s must be above 0");
    }
    if (yaw_ > 0) {
      const double yaw = number(column[std::size_t(yaw_)], "yaw_deg");
      if (std::abs(yaw) > kMaxYaw_deg)
        fail(fmt::format("yaw_deg = {} is beyond the limit of +-{}", yaw, kMaxYaw_deg));
      path_.yaw_point_rad.push_back(yaw * std::numbers::pi / 180.0);
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
  std::size_t used_ = 0;                              // bytes of the line that was handed out
  int line_ = 0, columns_ = 0, speed_ = 0, yaw_ = 0;  // column number, 0 = absent
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
  if (file.extension() == ".paths") return read_paths_layers(file, sink);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw UsageError(file.string() + ": cannot be read");
  const double size = double(std::filesystem::file_size(file, error));
  if (file.extension() == ".csv") return read_paths_csv(in, file.string(), size, sink);
  if (file.extension() == ".json") return read_paths_json(in, file.string(), size, sink);
  if (file.extension() == ".svg") return read_paths_svg(in, file.string(), size, sink);
  if (file.extension() == ".dxf") return read_paths_dxf(in, file.string(), size, sink);
  for (const char* extension : {".gcode", ".nc", ".ngc"})
    if (file.extension() == extension) return read_paths_gcode(in, file.string(), size, sink);
  throw UsageError(file.string() + ": must end in .gcode, .nc, .ngc, .dxf, .svg, .csv, .json or .paths");
}

}  // namespace firn
