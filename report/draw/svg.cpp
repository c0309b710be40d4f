#include "report/draw/svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/options/for_people.h"

namespace firn::report {
namespace {

constexpr double kNarrowest = 1e-12;  // range of an axis, relative to its values

// 1, 2 or 5 times a power of ten, not below `rough`.
double round_step(double rough) {
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough * 0.999) return factor * power;
  return 10.0 * power;
}

}  // namespace

std::string table_row(const std::vector<std::string>& cells, const char* tag) {
  std::string s = "<tr>";
  for (const std::string& c : cells) s += std::string("<") + tag + ">" + c + "</" + tag + ">";
  return s + "</tr>\n";
}

std::string escape_html(std::string_view text) {
  std::string s;
  for (char c : text) switch (c) {
      case '&':
        s += "&amp;";
        break;
      case '<':
        s += "&lt;";
        break;
      case '>':
        s += "&gt;";
        break;
      case '"':
        s += "&quot;";
        break;
      default:
        s += c;
    }
  return s;
}

std::string_view shortened(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xC0) == 0x80) --bytes;
  return text.substr(0, bytes);
}

std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string s = text;
  if (s.find_first_not_of("-0.") == s.npos && s[0] == '-') s.erase(0, 1);  // no "-0.00"
  return s[0] == '-' ? "−" + s.substr(1) : s;
}

std::string number(double value) {
  if (!std::isfinite(value)) return "–";
  const std::string s = for_people(value);
  return s[0] == '-' ? "−" + s.substr(1) : s;
}

Axis::Axis(double low, double high, double from_px, double to_px, int wanted, Kind kind)
    : low_(low), high_(high), from_px_(from_px), to_px_(to_px), kind_(kind) {
  // Between neighbouring doubles there is no room for ticks: counting them up would not end.
  if (!(high_ - low_ > kNarrowest * std::max(std::abs(low_), std::abs(high_)))) {
    const double half = kind == Kind::kLogarithmic ? 0.5 * low_ : std::max(1.0, std::abs(low_) * 0.5);
    low_ -= half;
    high_ += half;
  }
  if (kind_ == Kind::kLogarithmic) {
    for (double power = std::pow(10.0, std::floor(std::log10(low_))); power <= high_; power *= 10)
      for (double factor : {1.0, 2.0, 5.0})
        if (const double v = factor * power; v >= low_ * 0.999 && v <= high_ * 1.001)
          ticks_.push_back({v, number(v, std::max(0, int(-std::floor(std::log10(power) + 1e-9))))});
    if (ticks_.size() > 1) return;
    ticks_.clear();  // within less than a factor: as on a linear axis
  }
  double step = round_step((high_ - low_) / wanted);
  if (kind_ == Kind::kWhole) step = std::max(1.0, step);
  const int decimals = std::max(0, int(-std::floor(std::log10(step) + 1e-9)));
  const double slack = 1e-6 * (high_ - low_);
  for (double n = std::ceil((low_ - slack) / step); n * step <= high_ + slack; ++n)
    ticks_.push_back({n * step, number(n * step, decimals)});
}

double Axis::px(double value) const {
  const double share = kind_ == Kind::kLogarithmic
                           ? (std::log10(value) - std::log10(low_)) / (std::log10(high_) - std::log10(low_))
                           : (value - low_) / (high_ - low_);
  return from_px_ + share * (to_px_ - from_px_);
}

std::string svg_open(double width, double height, std::string_view title) {
  char text[160];
  std::snprintf(text, sizeof text,
                "<svg viewBox=\"0 0 %g %g\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">", width,
                height);
  return std::string(text) + "<title>" + escape_html(title) + "</title>\n";
}

std::string svg_text(double x, double y, std::string_view anchor, std::string_view cls,
                     std::string_view content) {
  char text[160];
  std::snprintf(text, sizeof text, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%.*s\" class=\"%.*s\">", x, y,
                int(anchor.size()), anchor.data(), int(cls.size()), cls.data());
  return text + escape_html(content) + "</text>\n";
}

std::string draw_axes(const Frame& f, const Axis& x, const Axis& y, std::string_view x_name,
                      std::string_view y_name) {
  std::string s;
  char line[200];
  for (const Axis::Tick& t : y.ticks()) {
    const double at = y.px(t.value);
    std::snprintf(line, sizeof line, "<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", f.left, at, f.right);
    s += line + svg_text(f.left - 6, at + 4, "end", "tick", t.text);
  }
  for (const Axis::Tick& t : x.ticks()) {
    const double at = x.px(t.value);
    std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fv4\"/>", at, f.bottom);
    s += line + svg_text(at, f.bottom + 17, "middle", "tick", t.text);
  }
  std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fV%.1fH%.1f\"/>", f.left, f.top,
                f.bottom, f.right);
  s += line + svg_text((f.left + f.right) / 2, f.bottom + 36, "middle", "name", x_name);
  std::snprintf(line, sizeof line, "<g transform=\"translate(13 %.1f) rotate(-90)\">",
                (f.top + f.bottom) / 2);
  return s + line + svg_text(0, 0, "middle", "name", y_name) + "</g>\n";
}

}  // namespace firn::report
