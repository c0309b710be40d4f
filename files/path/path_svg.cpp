// Reads paths from SVG: every subpath of the shapes that are drawn, in mm, with y upwards.
#include <expat.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <istream>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"
#include "files/path/svg_shapes.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMostDepth = 200;
constexpr double kPixel_mm = 25.4 / 96.0;

/// Elements whose content is not drawn where it stands.
constexpr std::array<std::string_view, 10> kSvgNotDrawn{"defs", "symbol", "marker", "pattern", "clipPath",
                                                        "mask", "style",  "script", "filter",  "metadata"};
/// Elements that would be drawn, but are no shapes.
constexpr std::array<std::string_view, 4> kRefused{"use", "text", "image", "foreignObject"};

class SvgReader {
 public:
  SvgReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink), parser_(XML_ParserCreate(nullptr)) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const char* element, const char** attributes) {
          static_cast<SvgReader*>(self)->guarded(
              [&](SvgReader& reader) { reader.start(element, attributes); });
        },
        [](void* self, const char*) {
          static_cast<SvgReader*>(self)->guarded([](SvgReader& reader) { reader.end(); });
        });
  }

  void read() {
    constexpr std::size_t kBlock = 1 << 16;
    std::vector<char> block(kBlock);
    for (bool last = false; !last;) {
      in_.read(block.data(), std::streamsize(kBlock));
      last = !in_;
      const auto status = XML_Parse(parser_.get(), block.data(), int(in_.gcount()), last);
      if (error_) std::rethrow_exception(error_);
      if (status != XML_STATUS_OK)
        fail(fmt::format("is not XML: {}", XML_ErrorString(XML_GetErrorCode(parser_.get()))));
    }
    if (paths_ == 0) fail("holds no path");
  }

 private:
  struct Free {
    void operator()(XML_Parser p) const { XML_ParserFree(p); }
  };
  struct Attributes {
    const char** of;
    std::optional<std::string_view> operator[](std::string_view key) const {
      for (const char** a = of; a[0]; a += 2)
        if (key == a[0]) return a[1];
      return std::nullopt;
    }
  };

  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(
        fmt::format("{}:{}: {}", name_, std::size_t(XML_GetCurrentLineNumber(parser_.get())), problem));
  }

  /// Exceptions do not pass through the parser, which is C.
  template <class Action>
  void guarded(Action&& action) {
    if (error_) return;
    try {
      action(*this);
    } catch (const svg::SyntaxError& e) {
      try {
        fail(e.what());
      } catch (...) {
        error_ = std::current_exception();
      }
      XML_StopParser(parser_.get(), XML_FALSE);
    } catch (...) {
      error_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void start(std::string_view element, const char** list) {
    if (const std::size_t colon = element.rfind(':'); colon != element.npos) element.remove_prefix(colon + 1);
    if (stack_.size() == kMostDepth) fail(fmt::format("elements nested deeper than {}", kMostDepth));
    if (stack_.empty()) {
      if (element != "svg") fail("the first element must be svg");
      stack_.push_back(page({list}));
      return;
    }
    const Attributes attributes{list};
    State state = stack_.back();
    const auto is = [&](std::string_view other) { return other == element; };
    const auto display = property(attributes, "display"), visibility = property(attributes, "visibility");
    if (std::any_of(kSvgNotDrawn.begin(), kSvgNotDrawn.end(), is) || (display && *display == "none"))
      state.drawn = false;
    if (visibility) state.visible = *visibility != "hidden" && *visibility != "collapse";
    if (state.drawn && std::any_of(kRefused.begin(), kRefused.end(), is))
      fail(fmt::format("<{}> is not read: turn it into paths", element));
    if (state.drawn && is("svg")) fail("an svg inside of an svg is not read");
    for (const char* cut : {"clip-path", "mask"})
      if (const auto by = property(attributes, cut); state.drawn && by && *by != "none")
        fail(fmt::format("{} = {}: what it cuts off would be drawn: remove it", cut, by->substr(0, 40)));
    if (const auto text = attributes["transform"]) state.transform = state.transform * svg::transform(*text);
    stack_.push_back(state);
    if (state.drawn && state.visible) draw(element, attributes, state.transform);
  }

  void end() { stack_.pop_back(); }

  struct State {
    svg::Transform transform;
    bool drawn = true, visible = true;
  };

  /// A presentation property: of the style attribute, or an attribute of its own.
  static std::optional<std::string_view> property(const Attributes& attributes, std::string_view key) {
    std::optional<std::string_view> found = attributes[key];
    std::string_view style = attributes["style"].value_or("");
    while (!style.empty()) {
      const std::string_view one = style.substr(0, style.find(';'));
      style.remove_prefix(std::min(style.size(), one.size() + 1));
      const std::size_t colon = one.find(':');
      if (colon == one.npos || trimmed(one.substr(0, colon)) != key) continue;
      const std::string_view value = trimmed(one.substr(colon + 1));
      found = trimmed(value.substr(0, value.find('!')));  // !important
    }
    return found;
  }

  /// From the user's units, y downwards, to mm, y upwards, with the origin at the page's lower left corner.
  State page(const Attributes& attributes) const {
    double box[4] = {0.0, 0.0, 0.0, 0.0}, scale = kPixel_mm;
    const auto length = [&](const char* key) -> std::optional<double> {
      const auto text = attributes[key];
      if (!text || text->ends_with('%')) return std::nullopt;
      const double mm = svg::length_mm(*text);
      if (!(mm > 0.0)) fail(fmt::format("{} = {}: must be above 0", key, text->substr(0, 40)));
      return mm;
    };
    const std::optional<double> width = length("width"), height = length("height");
    if (const auto text = attributes["viewBox"]) {
      svg::numbers(*text, box);
      if (!(box[2] > 0.0) || !(box[3] > 0.0)) fail("viewBox: its width and height must be above 0");
      if (width && height)
        return placed(box, *width, *height, attributes["preserveAspectRatio"].value_or(""));
      if (width || height) scale = width ? *width / box[2] : *height / box[3];
    } else if (height) {
      box[3] = *height / kPixel_mm;
    }
    return {{scale, 0.0, 0.0, -scale, -scale * box[0], scale * (box[1] + box[3])}, true};
  }

  /// The viewBox in a page of another shape: by default it is fitted in and centred.
  State placed(const double (&box)[4], double width, double height, std::string_view how) const {
    const double wide = width / box[2], high = height / box[3];
    const auto word = [&] {
      const std::string_view one = trimmed(how).substr(0, trimmed(how).find(' '));
      how = trimmed(how).substr(one.size());
      return one;
    };
    std::string_view align = word();
    if (align.empty()) align = "xMidYMid";
    if (align == "none") return {{wide, 0.0, 0.0, -high, -wide * box[0], high * (box[1] + box[3])}, true};
    const auto share = [&](std::string_view text) {
      return text == "Min" ? 0.0 : text == "Mid" ? 0.5 : text == "Max" ? 1.0 : -1.0;
    };
    const double x = align.size() == 8 && align[0] == 'x' ? share(align.substr(1, 3)) : -1.0,
                 y = align.size() == 8 && align[4] == 'Y' ? share(align.substr(5)) : -1.0;
    const std::string_view fit = word();
    if (x < 0.0 || y < 0.0 || (!fit.empty() && fit != "meet" && fit != "slice"))
      fail("preserveAspectRatio: none, or such as xMidYMid, then meet or slice");
    const double scale = fit == "slice" ? std::max(wide, high) : std::min(wide, high);
    const double left = scale == wide ? 0.0 : x * (width - scale * box[2]),
                 below = scale == high ? 0.0 : (1.0 - y) * (height - scale * box[3]);
    return {{scale, 0.0, 0.0, -scale, left - scale * box[0], below + scale * (box[1] + box[3])}, true};
  }

  void draw(std::string_view element, const Attributes& attributes, const svg::Transform& to_mm) {
    const svg::Target target{[this](Point2 p) { begin(p); }, [this](Point2 p) { add(p); },
                             [this](Point2 b, Point2 c, Point2 d) { add_bezier(b, c, d); },
                             [this](Point2 centre, double side, Point2 to) { add_arc(centre, side, to); }};
    svg::Pen pen(to_mm, target);
    const auto value = [&](const char* key) {
      const auto text = attributes[key];
      return text && *text != "auto" ? svg::length_mm(*text) / kPixel_mm : 0.0;
    };
    // of a rect's two radii one is enough
    const auto radius = [&](const char* key, const char* other) {
      const auto text = attributes[key];
      return text && *text != "auto" ? key : other;
    };
    if (element == "path") {
      if (const auto d = attributes["d"]) svg::draw_path(*d, pen);
    } else if (element == "polyline" || element == "polygon") {
      if (const auto points = attributes["points"]) svg::draw_polygon(*points, element == "polygon", pen);
    } else if (element == "line") {
      pen.move({value("x1"), value("y1")});
      pen.line({value("x2"), value("y2")});
    } else if (element == "rect") {
      const double rx = value(radius("rx", "ry")), ry = value(radius("ry", "rx"));
      svg::draw_rect({value("x"), value("y")}, value("width"), value("height"), rx, ry, pen);
    } else if (element == "circle") {
      svg::draw_ellipse({value("cx"), value("cy")}, value("r"), value("r"), pen);
    } else if (element == "ellipse") {
      svg::draw_ellipse({value("cx"), value("cy")}, value("rx"), value("ry"), pen);
    } else {
      return;
    }
    finish();
  }

  void begin(Point2 p) {
    finish();
    check(p);
    path_.place = fmt::format("{}:{}", name_, std::size_t(XML_GetCurrentLineNumber(parser_.get())));
    path_.path.points.push_back(p);
  }

  void add(Point2 p) {
    check(p);
    if (p == last()) return;
    if (path_.path.points.size() == kMaxPathPoints)
      fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    path_.path.points.push_back(p);
  }

  void add_bezier(Point2 b, Point2 c, Point2 d) {
    const Point2 a = last();
    const std::size_t first = path_.path.points.size() - 1;
    const int samples = sample_bezier(a, b, c, d, [this](Point2 p) { add(p); });
    give_bezier(a, b, c, d, samples, first, path_.path.points.size() - 1, path_.given);
  }

  void add_arc(Point2 centre, double side, Point2 to) {
    const std::size_t first = path_.path.points.size() - 1;
    const auto exact = sample_arc(last(), to, centre, side, [this](Point2 p) { add(p); });
    give_arc(exact, side, first, path_.path.points.size() - 1, path_.given);
  }

  Point2 last() const { return path_.path.points.back(); }

  void check(Point2 p) const {
    for (const double v : {p.x_mm, p.y_mm})
      if (!(std::abs(v) <= kMaxCoordinate_mm))
        fail(fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
  }

  void finish() {
    if (path_.path.points.size() > 1) {
      path_.number = ++paths_;
      path_.fraction =
          size_ > 0.0 ? std::min(1.0, double(XML_GetCurrentByteIndex(parser_.get())) / size_) : 0.0;
      sink_(std::move(path_));
    }
    path_ = InputPath();
  }

  std::istream& in_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  std::exception_ptr error_;
  std::vector<State> stack_;
  InputPath path_;
  std::int64_t paths_ = 0;
};

}  // namespace

void read_paths_svg(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  SvgReader(in, name, size, sink).read();
}

}  // namespace firn
