#include "print/prepare/gcode.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/options/enumerators.h"

namespace firn {
namespace {

constexpr const char* kKinds[] = {"boundary", "fill", "hook", "measurement"};
static_assert(std::size(kKinds) == kTableSize<PathKind>);

// A line on its way to the text: one append for all of it.
class Line {
 public:
  explicit Line(std::string& out) : out_(out) {}
  ~Line() { out_.append(text_, std::size_t(at_ - text_)); }
  Line& word(std::string_view w) {
    at_ = std::copy(w.begin(), w.end(), at_);
    return *this;
  }
  // Appends a number with `digits` decimals, in units of the last; without trailing zeros, as G-code readers
  // expect.
  Line& fixed(std::int64_t value, int digits) {
    char back[24];
    char* at = back + sizeof back;
    std::uint64_t v = value < 0 ? std::uint64_t(-value) : std::uint64_t(value);
    for (; digits > 0 && v % 10 == 0; --digits) v /= 10;
    if (digits > 0) {
      for (; digits > 0; --digits, v /= 10) *--at = char('0' + v % 10);
      *--at = '.';
    }
    do *--at = char('0' + v % 10);
    while (v /= 10);
    if (value < 0) *--at = '-';
    at_ = std::copy(at, back + sizeof back, at_);
    return *this;
  }

 private:
  std::string& out_;
  char text_[160];  // of six words and numbers at most
  char* at_ = text_;
};

void append_lines(std::string& out, const std::string& lines) {
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = std::min(lines.find('|', begin), lines.size());
    out.append(lines, begin, end - begin);
    out += '\n';
    begin = end + 1;
  }
}

class LayerText {
 public:
  explicit LayerText(const GcodeSettings& settings)
      : g_(settings),
        x_(std::llround(settings.x_mm * geometry::kUnitsPerMm)),
        y_(std::llround(settings.y_mm * geometry::kUnitsPerMm)),
        per_mm3_(settings.filament_mm > 0.0
                     ? 4.0 / (std::numbers::pi * settings.filament_mm * settings.filament_mm)
                     : 1.0) {}

  std::string layer(const slice::LayerPaths& l) {
    out_.reserve(200 + 60 * l.lines.size() + 34 * l.lines.points.size());
    speed(Line(out_)
              .word(";LAYER:")
              .fixed(l.layer - 1, 0)
              .word("\n;Z:")
              .fixed(l.z, 4)
              .word("\nG1 Z")
              .fixed(l.z, 4),
          g_.travel_mm_s);
    int tool = -1;
    for (std::size_t n = 0; n < l.lines.size(); ++n) {
      const slice::PathInfo& info = l.info[n];
      out_ += ";TYPE:";
      out_ += kKinds[std::size_t(info.kind)];
      out_ += '\n';
      if (info.kind == PathKind::kMeasurement) {
        for (const geometry::Point& p : l.lines[n]) {
          Line text(out_);
          point(text, ";", p).word("\n");
        }
        continue;
      }
      if (info.material != tool) out_ += "T" + std::to_string(tool = info.material) + "\n";
      path(l.lines[n], info, l.height);
    }
    return std::move(out_);
  }

 private:
  static void speed(Line& line, double mm_s) {
    line.word(" F").fixed(std::llround(mm_s * 60.0 * 100.0), 2).word("\n");
  }
  Line& point(Line& line, const char* word, const geometry::Point& p) const {
    return line.word(word).word("X").fixed(p.x + x_, 4).word(" Y").fixed(p.y + y_, 4);
  }

  void path(std::span<const geometry::Point> line, const slice::PathInfo& info, std::int32_t height) {
    {
      Line text(out_);
      speed(point(text, "G0 ", line[0]), g_.travel_mm_s);
    }
    // E is rounded to 0.01 um of filament; the remainder is added to the next move.
    const double area_mm2 = double(info.width) * height * geometry::kMmPerUnit * geometry::kMmPerUnit;
    const double e_per_unit = area_mm2 * geometry::kMmPerUnit * per_mm3_ * 1e5;
    double owed = 0.0;
    bool first = true;
    const auto move = [&](const geometry::Point& from, const geometry::Point& to) {
      const double dx = double(to.x) - from.x, dy = double(to.y) - from.y;
      owed += std::sqrt(dx * dx + dy * dy) * e_per_unit;
      const auto e = std::int64_t(owed + 0.5);
      owed -= double(e);
      Line text(out_);
      point(text, "G1 ", to).word(" E").fixed(e, 5);
      if (first)
        speed(text, info.kind == PathKind::kFill ? g_.fill_mm_s : g_.boundary_mm_s);
      else
        text.word("\n");
      first = false;
    };
    for (std::size_t n = 1; n < line.size(); ++n) move(line[n - 1], line[n]);
    if (info.closed && line.size() > 1) move(line.back(), line[0]);
  }

  const GcodeSettings& g_;
  std::int64_t x_, y_;
  double per_mm3_;
  std::string out_;
};

}  // namespace

std::string gcode_start(const GcodeSettings& settings, const std::string& made_by) {
  std::string out = "; " + made_by + "\nG21 ; mm\nG90 ; absolute coordinates\nM83 ; relative extrusion";
  out += settings.filament_mm > 0.0 ? ", mm of filament\n" : ", mm^3\n";
  append_lines(out, settings.start);
  return out;
}

std::string gcode_layer(const slice::LayerPaths& layer, const GcodeSettings& settings) {
  return LayerText(settings).layer(layer);
}

std::string gcode_end(const GcodeSettings& settings) {
  std::string out;
  append_lines(out, settings.end);
  return out + "; end\n";
}

}  // namespace firn
