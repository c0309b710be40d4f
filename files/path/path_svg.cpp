// Reads paths from SVG: every subpath of the shapes that are painted, in mm, with y upwards.
//
// The reader of style sheets is Firn's own. librsvg, which Debian has, gives pixels or Cairo's curves, whose
// coordinates are rounded to 1/256 and have no arcs, and draws nothing of unknown elements; SVG++ knows
// no style sheets.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/lowercase.h"
#include "files/path/path_file.h"
#include "files/path/svg_document.h"
#include "files/path/svg_frames.h"
#include "files/path/svg_paint.h"
#include "files/path/svg_path_maker.h"
#include "files/path/svg_shapes.h"
#include "files/path/svg_style.h"
#include "files/trimmed.h"
#include "files/usage_error.h"

namespace firn {
namespace {

using svg::Element;
using svg::Properties;
using svg::SyntaxError;

constexpr std::size_t kMaxUses = 1000000;

template <std::size_t n>
bool is_among(const std::array<std::string_view, n>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Elements that are not drawn where they are defined.
constexpr std::array<std::string_view, 33> kSvgNotDrawn{
    "defs",   "symbol",         "marker",         "pattern",      "clipPath",      "mask",
    "style",  "filter",         "metadata",       "title",        "desc",          "view",
    "cursor", "font",           "font-face",      "glyph",        "missing-glyph", "hkern",
    "vkern",  "linearGradient", "radialGradient", "stop",         "solidColor",    "color-profile",
    "hatch",  "script",         "animate",        "animateColor", "animateMotion", "animateTransform",
    "set",    "mpath",          "discard"};
/// Of these, such as change a drawing later.
constexpr std::array<std::string_view, 6> kChangesLater{"script",        "animate",          "animateColor",
                                                        "animateMotion", "animateTransform", "set"};
constexpr std::array<std::string_view, 3> kSvgGroups{"g", "a", "svg"};
constexpr std::array<std::string_view, 7> kSvgShapes{"path", "line",   "polyline", "polygon",
                                                     "rect", "circle", "ellipse"};

/// Properties that an element inherits.
struct Frame {
  PlaneTransform to_mm;
  svg::Painting painting;
  svg::Viewport viewport;
  const svg::Cut* cut = nullptr;
};

class SvgReader {
 public:
  SvgReader(svg::Document&& document, const std::string& name, double size, const PathSink& sink)
      : document_(std::move(document)),
        name_(name),
        size_(size),
        sink_(sink),
        cascade_(styles()),
        paths_(sink) {}

  void read() {
    const Element& root = document_.elements.front();
    guarded(root.line, [&] {
      const Properties own = cascade_.of(root);
      if (const auto* const moved = own.find("transform"); moved && lowercase(moved->text) != "none")
        throw SyntaxError(
            "a transform of the outermost svg is not read, since programs differ: move it to a <g>");
      Frame page = this->page(root, own);
      page.painting = painting({}, own, document_);
      if (svg::is_shown(own))
        for (const Element* child : root.children) visit(*child, page, nullptr);
      else
        ++hidden_;
    });
    if (paths_.count() == 0)
      throw UsageError(fmt::format("{}: holds no path that is drawn{}", name_, left_out()));
    if (const std::string what = left_out(); !what.empty()) sink_.note(name_ + what);
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line, problem));
  }

  template <class Action>
  void guarded(std::size_t line, Action&& action) const {
    try {
      action();
    } catch (const SyntaxError& e) {
      fail(line, e.what());
    }
  }

  svg::Cascade styles() const {
    std::size_t line = 1;
    try {
      return svg::Cascade(document_, line);
    } catch (const SyntaxError& e) {
      fail(line, e.what());
    }
  }

  /// ": 2 elements are not painted; passed over: 1 marker".
  std::string left_out() const {
    std::string out;
    if (hidden_ > 0) out += fmt::format("; {} hidden, or neither filled nor stroked", hidden_);
    if (empty_ > 0)
      out += fmt::format("; {} of length 0 left out, the first in line {}", empty_, first_empty_);
    for (const auto& [what, count] : passed_over_)
      out +=
          fmt::format("{}{} {}", what == passed_over_.begin()->first ? "; passed over: " : ", ", count, what);
    if (!out.empty()) out[0] = ':';
    return out;
  }

  /// From the user's units to mm, y upwards, with the origin at the page's lower left corner.
  Frame page(const Element& root, const Properties& own) const {
    double box[4] = {0.0, 0.0, 0.0, 0.0};
    const auto size_mm = [&](const char* key) -> std::optional<double> {
      const svg::Value* const value = own.find(key);
      if (value == nullptr || lowercase(value->text) == "auto") return std::nullopt;
      const svg::Length length = named(key, *value);
      if (length.unit == svg::Length::Unit::kPercent) return std::nullopt;
      if (!(length.value > 0.0))
        throw SyntaxError(fmt::format("{} = {}: must be above 0", key, value->text.substr(0, 40)));
      return length.unit == svg::Length::Unit::kMillimetre ? length.value : svg::kPixel_mm * length.user({});
    };
    const std::optional<double> width = size_mm("width"), height = size_mm("height");
    Frame out;
    double high = height.value_or(0.0), scale = svg::kPixel_mm;
    if (!view_box(root, box)) {
      out.to_mm = PlaneTransform::scaling(scale, scale);
      if (width) out.viewport.width = *width / scale;
      if (height) out.viewport.height = *height / scale;
    } else {
      out.viewport = {box[2], box[3]};
      if (width && height) {
        out.to_mm = svg::fit(box, *width, *height, root["preserveAspectRatio"].value_or(""));
      } else {
        if (width || height) scale = width ? *width / box[2] : *height / box[3];
        out.to_mm = {scale, 0.0, 0.0, scale, -scale * box[0], -scale * box[1]};
        high = scale * box[3];
      }
    }
    out.to_mm = PlaneTransform{1.0, 0.0, 0.0, -1.0, 0.0, high} * out.to_mm;
    return out;
  }

  static bool view_box(const Element& e, double (&box)[4]) {
    const auto text = e["viewBox"];
    if (!text) return false;
    svg::numbers(*text, box);
    if (!(box[2] > 0.0) || !(box[3] > 0.0))
      throw SyntaxError("viewBox: its width and height must be above 0");
    return true;
  }

  static svg::Length named(std::string_view key, const svg::Value& value) {
    try {
      return svg::length(value);
    } catch (const SyntaxError& e) {
      throw SyntaxError(fmt::format("{} = {}", key, e.what()));
    }
  }

  /// A length in user units; `otherwise` where the element does not have it.
  static double size(const Properties& own, const char* key, std::optional<double> whole,
                     std::optional<double> otherwise) {
    const svg::Value* const value = own.find(key);
    if (value == nullptr || lowercase(value->text) == "auto") {
      if (!otherwise)
        throw SyntaxError(
            fmt::format("{} is the whole of a page without a size: give the svg a viewBox", key));
      return *otherwise;
    }
    return named(key, *value).user(whole);
  }
  static double extent(const Properties& own, const char* key, std::optional<double> whole,
                       std::optional<double> otherwise) {
    const double found = size(own, key, whole, otherwise);
    if (found < 0.0) throw SyntaxError(fmt::format("{} = {}: must not be below 0", key, found));
    return found;
  }

  /// @param use properties of the <use> that inserts the element, or none
  void visit(const Element& e, const Frame& outer, const Properties* use) {
    guarded(e.line, [&] {
      if (depth_ == svg::kMaxDepth)
        throw SyntaxError(fmt::format("elements nested deeper than {}, with those of <use>", svg::kMaxDepth));
      ++depth_;
      visit_element(e, outer, use);
      --depth_;
    });
  }

  void visit_element(const Element& e, const Frame& outer, const Properties* use) {
    const bool is_symbol = e.name == "symbol" && use != nullptr;
    if (is_among(kSvgNotDrawn, e.name) && !is_symbol) {
      if (is_among(kChangesLater, e.name)) ++passed_over_["<" + e.name + ">"];
      return;
    }
    if (!meets_conditions(e)) return;
    const Properties own = cascade_.of(e);
    for (const char* unread : {"all", "d"})
      if (own.find(unread)) throw SyntaxError(fmt::format("style: {} is not read", unread));
    Frame frame = outer;
    frame.to_mm = outer.to_mm * svg::transform(own, outer.viewport);
    if (!svg::is_shown(own) || !(std::abs(frame.to_mm.determinant()) > 0.0)) {
      ++hidden_;
      return;
    }
    frame.painting = painting(outer.painting, own, document_);
    const std::optional<svg::Cut> clip = clip_path(own, frame);
    if (clip) frame.cut = &*clip;
    if (const svg::Value* const filter = own.find("filter"); filter && filter->text != "none")
      ++passed_over_["filter"];
    if (is_among(kSvgShapes, e.name)) return shape(e, own, frame);
    if (e.name == "use") return insert(e, own, frame);
    if (e.name == "svg" || is_symbol) return viewport(e, own, frame, use);
    if (e.name == "switch") return choose(e, frame);
    if (is_among(kSvgGroups, e.name)) return children(e, frame);
    if (!shows(e, frame)) {
      ++hidden_;
      return;
    }
    throw SyntaxError(e.name == "text" ? std::string("<text> is not read: turn it into paths, or hide it")
                                       : fmt::format("<{}> is not read: turn it into paths, or remove it",
                                                     e.name.substr(0, 40)));
  }

  void children(const Element& e, const Frame& frame) {
    for (const Element* child : e.children) visit(*child, frame, nullptr);
  }

  /// Draws the first child whose conditions are met.
  void choose(const Element& e, const Frame& frame) {
    for (const Element* child : e.children)
      if (!is_among(kSvgNotDrawn, child->name) && meets_conditions(*child))
        return visit(*child, frame, nullptr);
  }

  /// No extension is known; the reader's language is English.
  static bool meets_conditions(const Element& e) {
    if (e["requiredExtensions"]) return false;
    if (const auto features = e["requiredFeatures"]; features && trimmed(*features).empty()) return false;
    const auto languages = e["systemLanguage"];
    if (!languages) return true;
    std::string_view rest = *languages;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.size(), rest.find(','));
      const std::string one = lowercase(trimmed(rest.substr(0, end)));
      if (one == "en" || one.starts_with("en-")) return true;
      rest.remove_prefix(std::min(rest.size(), end + 1));
    }
    return false;
  }

  /// Says whether an element that is no shape would be seen; a text only where it has letters.
  bool shows(const Element& e, const Frame& outer) const {
    if (e.name == "image" || e.name == "foreignObject") return outer.painting.is_visible;
    if (outer.painting.paints() && !trimmed(e.text).empty()) return true;
    const bool is_text =
        e.name == "text" || e.name == "tspan" || e.name == "textPath" || e.name == "a" || e.name == "tref";
    if (!is_text) return outer.painting.is_visible;
    return std::any_of(e.children.begin(), e.children.end(), [&](const Element* child) {
      const Properties own = cascade_.of(*child);
      if (is_among(kSvgNotDrawn, child->name) || !svg::is_shown(own)) return false;
      Frame frame = outer;
      frame.painting = painting(outer.painting, own, document_);
      return shows(*child, frame);
    });
  }

  /// The rectangle of a clip-path; absent without one. Nothing may leave it, so that it changes nothing.
  /// @throws SyntaxError for any other form, and for a mask
  std::optional<svg::Cut> clip_path(const Properties& own, const Frame& frame) const {
    for (const char* mask : {"mask", "mask-image"})
      if (const svg::Value* const by = own.find(mask); by && lowercase(by->text) != "none")
        throw SyntaxError(
            fmt::format("{} = {}: what it hides would be drawn: remove it", mask, by->text.substr(0, 40)));
    const svg::Value* const by = own.find("clip-path");
    if (by == nullptr || lowercase(by->text) == "none") return std::nullopt;
    const auto refuse = [&] {
      throw SyntaxError(
          fmt::format("clip-path = {}: what it cuts off would be drawn (a single rect is read): remove it",
                      by->text.substr(0, 40)));
    };
    const auto found = document_.by_id.find(svg::referenced_id(by->text));
    if (found == document_.by_id.end()) refuse();
    const Element& clip = *found->second;
    const bool in_user_space = clip["clipPathUnits"].value_or("userSpaceOnUse") == "userSpaceOnUse";
    if (clip.name != "clipPath" || !in_user_space || clip.children.size() != 1) refuse();
    const Element& rect = *clip.children.front();
    const Properties of_clip = cascade_.of(clip), of_rect = cascade_.of(rect);
    if (rect.name != "rect" || of_rect.find("rx") || of_rect.find("ry") || of_clip.find("clip-path") ||
        of_rect.find("clip-path"))
      refuse();
    const PlaneTransform to_mm =
        frame.to_mm * svg::transform(of_clip, frame.viewport) * svg::transform(of_rect, frame.viewport);
    if (!(std::abs(to_mm.determinant()) > 0.0)) refuse();
    const auto& [width, height] = frame.viewport;
    return svg::Cut{to_mm.inverse(),
                    size(of_rect, "x", width, 0.0),
                    size(of_rect, "y", height, 0.0),
                    extent(of_rect, "width", width, 0.0),
                    extent(of_rect, "height", height, 0.0),
                    "clip-path",
                    rect.line,
                    frame.cut};
  }

  /// The content of an inner svg, or of a symbol.
  void viewport(const Element& e, const Properties& own, Frame frame, const Properties* use) {
    const auto [outer_width, outer_height] = frame.viewport;
    const auto side = [&](const char* key, std::optional<double> whole) {
      return extent(use && use->find(key) ? *use : own, key, whole, whole);
    };
    const double width = side("width", outer_width), height = side("height", outer_height);
    if (!(width > 0.0) || !(height > 0.0)) {
      ++hidden_;
      return;
    }
    frame.to_mm = frame.to_mm * PlaneTransform::translation(size(own, "x", outer_width, 0.0),
                                                            size(own, "y", outer_height, 0.0));
    const svg::Value* const overflow = own.find("overflow");
    const std::string beyond = overflow ? lowercase(overflow->text) : "hidden";
    const svg::Cut cut{frame.to_mm.inverse(), 0.0, 0.0, width, height, "<" + e.name + ">", e.line, frame.cut};
    if (beyond != "visible" && beyond != "auto") frame.cut = &cut;
    double box[4];
    if (view_box(e, box)) {
      frame.to_mm = frame.to_mm * svg::fit(box, width, height, e["preserveAspectRatio"].value_or(""));
      frame.viewport = {box[2], box[3]};
    } else {
      frame.viewport = {width, height};
    }
    children(e, frame);
  }

  /// Draws the target of a <use>.
  void insert(const Element& e, const Properties& own, Frame frame) {
    const auto reference = e["href"];
    if (!reference) return;
    const std::string shown(trimmed(*reference).substr(0, 40));
    const auto found = document_.by_id.find(svg::referenced_id(*reference));
    if (found == document_.by_id.end())
      throw SyntaxError(fmt::format("<use> of \"{}\", which the file does not hold", shown));
    const Element* const target = found->second;
    if (std::find(inserted_.begin(), inserted_.end(), target) != inserted_.end())
      throw SyntaxError(fmt::format("<use> of \"{}\" within itself", shown));
    if (++uses_ > kMaxUses)
      throw SyntaxError(fmt::format("more than {} elements inserted by <use>", kMaxUses));
    frame.to_mm = frame.to_mm * PlaneTransform::translation(size(own, "x", frame.viewport.width, 0.0),
                                                            size(own, "y", frame.viewport.height, 0.0));
    inserted_.push_back(target);
    visit(*target, frame, &own);
    inserted_.pop_back();
  }

  void shape(const Element& e, const Properties& own, const Frame& frame) {
    if (!frame.painting.paints()) {
      ++hidden_;
      return;
    }
    for (const char* marker : {"marker", "marker-start", "marker-mid", "marker-end"})
      if (const svg::Value* const value = own.find(marker); value && value->text != "none")
        ++passed_over_[marker];
    for (const Element* child : e.children)
      if (is_among(kChangesLater, child->name)) ++passed_over_["<" + child->name + ">"];
    if (const svg::Value* const fill = own.find("fill"); fill && frame.painting.fills()) {
      const auto found = document_.by_id.find(svg::referenced_id(fill->text));
      if (found != document_.by_id.end() && found->second->name == "pattern") ++passed_over_["<pattern>"];
    }
    byte_ = std::max(byte_, e.byte);
    paths_.begin_shape(fmt::format("{}:{}", name_, e.line),
                       size_ > 0.0 ? std::min(1.0, double(byte_) / size_) : 0.0, frame.cut);
    draw(e, own, frame);
    if (!paths_.finish_shape() && empty_++ == 0) first_empty_ = e.line;
  }

  void draw(const Element& e, const Properties& own, const Frame& frame) {
    svg::Pen pen(frame.to_mm, paths_.target());
    const auto& [width, height] = frame.viewport;
    const auto x = [&, w = width](const char* key) { return size(own, key, w, 0.0); };
    const auto y = [&, h = height](const char* key) { return size(own, key, h, 0.0); };
    const auto end = [&](const char* key, std::optional<double> whole) {
      const auto text = e[key];
      return text ? named(key, {std::string(*text), false}).user(whole) : 0.0;
    };
    const auto radius = [&](const char* key, std::optional<double> whole, double otherwise) {
      return extent(own, key, whole, otherwise);
    };
    if (e.name == "path") {
      if (const auto d = e["d"]) svg::draw_path(*d, pen);
    } else if (e.name == "polyline" || e.name == "polygon") {
      if (const auto points = e["points"]) svg::draw_polygon(*points, e.name == "polygon", pen);
    } else if (e.name == "line") {
      pen.move({end("x1", width), end("y1", height)});
      pen.line({end("x2", width), end("y2", height)});
    } else if (e.name == "rect") {
      // of its two radii one is enough
      const double other = radius("ry", height, 0.0), rx = radius("rx", width, other),
                   ry = radius("ry", height, rx);
      svg::draw_rect({x("x"), y("y")}, radius("width", width, 0.0), radius("height", height, 0.0), rx, ry,
                     pen);
    } else if (e.name == "circle") {
      const double r = radius("r", frame.viewport.diagonal(), 0.0);
      svg::draw_ellipse({x("cx"), y("cy")}, r, r, pen);
    } else {
      const double other = radius("ry", height, 0.0), rx = radius("rx", width, other);
      svg::draw_ellipse({x("cx"), y("cy")}, rx, radius("ry", height, rx), pen);
    }
  }

  const svg::Document document_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  const svg::Cascade cascade_;
  std::vector<const Element*> inserted_;  ///< by <use>, each within the one before
  svg::PathMaker paths_;
  std::size_t byte_ = 0;  ///< of the furthest shape so far
  std::size_t depth_ = 0, uses_ = 0, hidden_ = 0, empty_ = 0, first_empty_ = 0;
  std::map<std::string, std::size_t> passed_over_;
};

}  // namespace

void read_paths_svg(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  SvgReader(svg::read_document(in, name), name, size, sink).read();
}

}  // namespace firn
