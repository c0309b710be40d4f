#include "report/paths/slice_pictures.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/grid/png.h"
#include "core/options/enumerators.h"
#include "lcmtypes/schema.h"

namespace firn::report {
namespace {

struct Colour {
  int r, g, b;
};
// Area, boundary, fill; by material, the last for all further ones.
constexpr std::array<std::array<Colour, 3>, 3> kColours{
    {{{{222, 236, 247}, {16, 78, 139}, {74, 144, 201}}},
     {{{252, 236, 216}, {176, 88, 12}, {226, 150, 72}}},
     {{{226, 242, 222}, {40, 110, 40}, {110, 176, 100}}}}};
constexpr Colour kHook{120, 40, 150}, kMeasurement{40, 40, 40};

const std::array<Colour, 3>& of_material(std::size_t material) {
  return kColours[std::min(material, kColours.size() - 1)];
}

Colour of_path(const slice::PathInfo& info) {
  if (info.kind == PathKind::kHook) return kHook;
  if (info.kind == PathKind::kMeasurement) return kMeasurement;
  return of_material(info.material)[info.kind == PathKind::kBoundary ? 1 : 2];
}

std::string label(const slice::LayerPaths& l) {
  return fmt::format("layer {}, {:g} mm", l.layer, l.z * geometry::kMmPerUnit);
}

// Computes the position of each layer on the sheet; mm, y downwards.
struct Sheet {
  double x0 = std::numeric_limits<double>::max(), y0 = x0, x1 = -x0, y1 = -x0, margin = 0.0, text = 0.0;
  std::size_t columns = 1, rows = 1;

  explicit Sheet(std::span<const PicturedLayer> layers) {
    for (const PicturedLayer& l : layers) {
      for (const geometry::Region& r : l.regions.by_material) take(r.points);
      take(l.paths.lines.points);
    }
    if (x0 > x1) {
      x0 = y0 = 0.0;
      x1 = y1 = 1.0;
    }
    margin = 0.03 * std::max(x1 - x0, y1 - y0);
    text = 1.4 * margin;
    // A sheet half as wide again as high, with few empty places.
    const std::size_t all = std::max<std::size_t>(1, layers.size());
    double best = std::numeric_limits<double>::max();
    for (std::size_t c = 1; c <= all; ++c) {
      const std::size_t r = (all + c - 1) / c;
      const double cost = std::abs(std::log(double(c) * cell_width() / (1.5 * double(r) * cell_height()))) +
                          double(r * c - all) / double(all);
      if (cost < best) {
        best = cost;
        columns = c;
      }
    }
    rows = (layers.size() + columns - 1) / columns;
  }
  void take(const std::vector<geometry::Point>& points) {
    for (const geometry::Point& p : points) {
      const double x = p.x * geometry::kMmPerUnit, y = p.y * geometry::kMmPerUnit;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x);
      y0 = std::min(y0, y);
      y1 = std::max(y1, y);
    }
  }
  double cell_width() const { return x1 - x0 + 2 * margin; }
  double cell_height() const { return y1 - y0 + 2 * margin + text; }
  double width() const { return double(columns) * cell_width(); }
  double height() const { return double(rows) * cell_height() + text; }  // the bar of the scale below
  double bar_y() const { return height() - 0.7 * text; }
  // A round length of at most a quarter of the part's width: 1, 2, 5, 10 mm and so on.
  double bar_mm() const {
    const double most = 0.25 * (x1 - x0), ten = std::pow(10.0, std::floor(std::log10(most)));
    return 5.0 * ten <= most ? 5.0 * ten : 2.0 * ten <= most ? 2.0 * ten : ten;
  }
  std::string bar_words() const { return fmt::format("{:g} mm", bar_mm()); }
  double left(std::size_t n) const { return double(n % columns) * cell_width() + margin - x0; }  // add to x
  double bottom(std::size_t n) const {
    return double(n / columns) * cell_height() + text + margin + y1;
  }  // subtract y
};

void append_data(std::string& out, std::span<const geometry::Point> line, bool closed) {
  char word = 'M';
  for (const geometry::Point& p : line) {
    fmt::format_to(std::back_inserter(out), "{}{:.2f} {:.2f}", word, p.x * geometry::kMmPerUnit,
                   -(p.y * geometry::kMmPerUnit));
    word = 'L';
  }
  if (closed) out += 'Z';
}

std::string hex(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

}  // namespace

std::string layers_svg(std::span<const PicturedLayer> layers) {
  const Sheet sheet(layers);
  const double line = std::max(sheet.width(), sheet.height()) / 1600.0;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.3f} {:.3f}\" width=\"{:.0f}\" "
      "font-family=\"sans-serif\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      sheet.width(), sheet.height(), 1200.0);
  out += fmt::format(
      "<path stroke=\"#333\" stroke-width=\"{:.3f}\" d=\"M{:.3f} {:.3f}h{:.3f}\"/>\n"
      "<text x=\"{:.3f}\" y=\"{:.3f}\" font-size=\"{:.3f}\" fill=\"#333\">{}</text>\n",
      4.0 * line, sheet.margin, sheet.bar_y(), sheet.bar_mm(), 1.5 * sheet.margin + sheet.bar_mm(),
      sheet.bar_y() + 0.25 * sheet.text, 0.75 * sheet.text, sheet.bar_words());
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const PicturedLayer& l = layers[n];
    out += fmt::format(
        "<g transform=\"translate({:.3f} {:.3f})\" fill=\"none\" stroke-linejoin=\"round\" "
        "stroke-linecap=\"round\">\n",
        sheet.left(n), sheet.bottom(n));
    for (std::size_t m = 0; m < l.regions.by_material.size(); ++m) {
      const geometry::Region& r = l.regions.by_material[m];
      if (r.empty()) continue;
      out += fmt::format("<path fill=\"{}\" fill-rule=\"evenodd\" d=\"", hex(of_material(m)[0]));
      for (std::size_t k = 0; k < r.size(); ++k) append_data(out, r[k], true);
      out += "\"/>\n";
    }
    for (std::size_t k = 0; k < l.paths.lines.size(); ++k) {
      const slice::PathInfo& info = l.paths.info[k];
      const bool boundary = info.kind == PathKind::kBoundary || info.kind == PathKind::kHook;
      out += fmt::format("<path stroke=\"{}\" stroke-width=\"{:.3f}\" d=\"", hex(of_path(info)),
                         boundary ? 1.6 * line : line);
      append_data(out, l.paths.lines[k], info.closed);
      out += "\"/>\n";
    }
    out += fmt::format("</g>\n<text x=\"{:.3f}\" y=\"{:.3f}\" font-size=\"{:.3f}\" fill=\"#333\">{}</text>\n",
                       sheet.left(n) + sheet.x0, sheet.bottom(n) - sheet.y1 - 0.4 * sheet.margin,
                       0.75 * sheet.text, label(l.paths));
  }
  return out + "</svg>\n";
}

std::string layers_png(std::span<const PicturedLayer> layers, int width_px) {
  constexpr int kShift = 4;            // OpenCV draws at sixteenths of a pixel
  constexpr double kHersheyPx = 30.0;  // height of its letters at size 1
  const Sheet sheet(layers);
  const double scale = double(width_px) / sheet.width();
  cv::Mat image(int(std::ceil(sheet.height() * scale)), width_px, CV_8UC3, cv::Scalar(255, 255, 255));
  const auto paint = [](const Colour& c) { return cv::Scalar(c.r, c.g, c.b); };
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const PicturedLayer& l = layers[n];
    const auto place = [&](std::span<const geometry::Point> line) {
      std::vector<cv::Point> out;
      for (const geometry::Point& p : line)
        out.emplace_back(
            int(std::lround((sheet.left(n) + p.x * geometry::kMmPerUnit) * scale * (1 << kShift))),
            int(std::lround((sheet.bottom(n) - p.y * geometry::kMmPerUnit) * scale * (1 << kShift))));
      return out;
    };
    for (std::size_t m = 0; m < l.regions.by_material.size(); ++m) {
      const geometry::Region& r = l.regions.by_material[m];
      std::vector<std::vector<cv::Point>> rings;
      for (std::size_t k = 0; k < r.size(); ++k) rings.push_back(place(r[k]));
      if (!rings.empty()) cv::fillPoly(image, rings, paint(of_material(m)[0]), cv::LINE_AA, kShift);
    }
    for (std::size_t k = 0; k < l.paths.lines.size(); ++k) {
      const slice::PathInfo& info = l.paths.info[k];
      const bool boundary = info.kind == PathKind::kBoundary || info.kind == PathKind::kHook;
      cv::polylines(image, std::vector{place(l.paths.lines[k])}, info.closed, paint(of_path(info)),
                    boundary && width_px >= 1000 ? 2 : 1, cv::LINE_AA, kShift);
    }
    const double font = 0.75 * sheet.text * scale / kHersheyPx;
    const cv::Point at(int((sheet.left(n) + sheet.x0) * scale),
                       int((sheet.bottom(n) - sheet.y1 - 0.4 * sheet.margin) * scale));
    cv::putText(image, label(l.paths), at, cv::FONT_HERSHEY_SIMPLEX, font, cv::Scalar(50, 50, 50), 1,
                cv::LINE_AA);
  }
  const auto at = [&](double x, double y) { return cv::Point(int(x * scale), int(y * scale)); };
  cv::line(image, at(sheet.margin, sheet.bar_y()), at(sheet.margin + sheet.bar_mm(), sheet.bar_y()),
           cv::Scalar(50, 50, 50), 3);
  cv::putText(image, sheet.bar_words(),
              at(1.5 * sheet.margin + sheet.bar_mm(), sheet.bar_y() + 0.25 * sheet.text),
              cv::FONT_HERSHEY_SIMPLEX, 0.75 * sheet.text * scale / kHersheyPx, cv::Scalar(50, 50, 50), 1,
              cv::LINE_AA);
  const std::vector<std::byte> bytes = write_png(image.cols, image.rows, 3, {image.data, image.total() * 3});
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string layer_json(const slice::LayerPaths& layer, std::span<const std::string> tools) {
  static constexpr const char* kKinds[] = {"boundary", "fill", "hook", "measurement"};
  static_assert(std::size(kKinds) == kTableSize<PathKind>);
  const auto mm = [](std::int32_t units) { return fmt::format("{:.4f}", units * geometry::kMmPerUnit); };
  std::string out = "{\"version\": 1, \"paths\": [";
  for (std::size_t n = 0; n < layer.lines.size(); ++n) {
    const slice::PathInfo& i = layer.info[n];
    out += fmt::format(
        "{}\n  {{\"layer\": {}, \"material\": {}, \"kind\": \"{}\", \"closed\": {}, \"width_mm\": {}, "
        "\"layer_height_mm\": {}, \"z_mm\": {}",
        n ? "," : "", layer.layer, i.material, kKinds[std::size_t(i.kind)], i.closed, mm(i.width),
        mm(layer.height), mm(layer.z));
    if (i.material < tools.size() && !tools[i.material].empty())
      out += ", \"tool\": " + json_string(tools[i.material]);
    out += ", \"points\": [";
    const char* comma = "";
    for (const geometry::Point& p : layer.lines[n]) {
      out += fmt::format("{}[{}, {}]", comma, mm(p.x), mm(p.y));
      comma = ", ";
    }
    out += "]}";
  }
  return out + "\n]}\n";
}

}  // namespace firn::report
