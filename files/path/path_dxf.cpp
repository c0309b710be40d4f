// Reads paths from DXF: the curves of a drawing's model space, joined where their ends meet.
//
// ASCII DXF is a list of pairs of lines, a group code and its value. The reader is Firn's own: dxflib, the
// library in Debian, is under the GPL, which Firn is not.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "files/path/dxf_shapes.h"
#include "files/path/join_curves.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMaxDxfLineBytes = 4096;
constexpr std::array<std::string_view, 2> kNotDrawn{"POINT", "VIEWPORT"};
constexpr const char* kRead = "LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE, POLYLINE and SPLINE are read";

/// Millimetres per unit of $INSUNITS.
std::optional<double> unit_mm(int code) {
  switch (code) {
    case 0:  // none
    case 4:
      return 1.0;
    case 1:
      return 25.4;
    case 2:
      return 304.8;
    case 5:
      return 10.0;
    case 6:
      return 1000.0;
    case 13:
      return 1e-3;
    case 14:
      return 100.0;
    default:
      return std::nullopt;
  }
}

std::string_view dxf_trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

/// Numbers of one entity, in the file's order.
struct Group {
  int code;
  double value;
};
struct Entity {
  std::string type, layer;
  std::vector<Group> groups;
  std::size_t line = 0;

  double operator()(int code, double otherwise) const {
    for (const Group& g : groups)
      if (g.code == code) return g.value;
    return otherwise;
  }
  bool flag(int code, int bit) const {
    const double value = (*this)(code, 0.0);
    return value >= 0.0 && value < 65536.0 && (int(value) & bit) != 0;
  }
};

class DxfReader {
 public:
  DxfReader(std::istream& in, const std::string& name, const PathSink& sink)
      : in_(in), name_(name), sink_(sink) {}

  void read() {
    while (true) {
      if (!next()) fail("ends before EOF");
      if (code_ == 0 && value_ == "EOF") break;
      if (code_ == 2 && section_begins_) {
        section_ = value_;
        section_begins_ = false;
        if (section_ == "ENTITIES") entities();
        if (value_ == "EOF") break;
        continue;
      }
      if (code_ == 0) {
        finish_layer();
        section_begins_ = value_ == "SECTION";
        if (value_ == "ENDSEC") section_.clear();
        in_layer_ = section_ == "TABLES" && value_ == "LAYER";
      } else if (section_ == "HEADER") {
        header();
      } else if (in_layer_) {
        layer();
      }
    }
    if (curves_.empty()) fail(fmt::format("holds no curve: {}", kRead));
    std::int64_t number = 0;
    std::size_t done = 0;
    join_curves(curves_, [&](JoinedCurve&& joined) {
      InputPath path;
      path.number = ++number;
      path.place = fmt::format("{}:{}", name_, joined.line);
      path.path.points = std::move(joined.shape.points);
      path.given = std::move(joined.shape.given);
      path.path.z_mm = joined.z_mm;
      done += joined.parts;
      path.fraction = double(done) / double(curves_.size());
      sink_(std::move(path));
    });
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line_, problem));
  }

  bool line(std::string& text) {
    if (!std::getline(in_, text)) return false;
    ++line_;
    if (text.size() > kMaxDxfLineBytes)
      fail(fmt::format("a line longer than the limit of {} bytes", kMaxDxfLineBytes));
    return true;
  }

  /// The next pair. False behind the last one.
  bool next() {
    if (!line(text_)) return false;
    if (line_ == 1 && text_.starts_with("AutoCAD Binary DXF")) fail("is a binary DXF: save it as ASCII");
    if (line_ == 1 && text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
    const std::string_view code = dxf_trimmed(text_);
    const auto [end, error] = std::from_chars(code.data(), code.data() + code.size(), code_);
    if (error != std::errc() || end != code.data() + code.size())
      fail(fmt::format("{} is not a group code: a whole number", shown(code)));
    if (!line(text_)) fail("ends inside of a group");
    value_ = std::string(dxf_trimmed(text_));
    return true;
  }

  static std::string shown(std::string_view text) {
    std::string out = "\"" + std::string(text.substr(0, 40)) + "\"";
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return out;
  }

  double number() const {
    const char* begin = value_.data() + (value_.starts_with('+') ? 1 : 0);
    double value = 0.0;
    const auto [end, error] = std::from_chars(begin, value_.data() + value_.size(), value);
    if (error != std::errc() || end != value_.data() + value_.size() || !std::isfinite(value))
      fail(fmt::format("group {}: {} is not a finite number", code_, shown(value_)));
    return value;
  }

  void header() {
    if (code_ == 9) variable_ = value_;
    if (code_ != 70 || variable_ != "$INSUNITS") return;
    const double code = number();
    const auto unit = code >= 0.0 && code < 100.0 ? unit_mm(int(code)) : std::nullopt;
    if (!unit)
      fail(
          fmt::format("$INSUNITS = {}: must be 0 or 4 (mm), 1 (inch), 2 (foot), 5 (cm), 6 (m), 13 (um) or 14 "
                      "(dm)",
                      code));
    unit_mm_ = *unit;
  }

  void layer() {
    if (code_ == 2) layer_name_ = value_;
    if (code_ == 62) layer_hidden_ = layer_hidden_ || number() < 0.0;                   // off
    if (code_ == 70) layer_hidden_ = layer_hidden_ || std::fmod(number(), 2.0) == 1.0;  // frozen
  }
  void finish_layer() {
    if (in_layer_ && layer_hidden_) hidden_.insert(layer_name_);
    layer_hidden_ = in_layer_ = false;
  }

  static bool holds_number(int code) {
    return (code >= 10 && code <= 79) || code == 90 || (code >= 210 && code <= 239);
  }

  /// The whole section; the pair that ends it is the present one.
  void entities() {
    Entity entity;
    std::vector<dxf::Vertex> vertices;
    std::optional<Entity> polyline;
    bool more = next();
    while (more && code_ == 0 && value_ != "ENDSEC" && value_ != "EOF") {
      entity = {value_, {}, {}, line_};
      while ((more = next()) && code_ != 0) {
        if (code_ == 8)
          entity.layer = value_;
        else if (holds_number(code_))
          entity.groups.push_back({code_, number()});
      }
      if (!more) fail("ends before EOF");
      try {
        if (polyline && entity.type == "VERTEX") {
          constexpr int kFrame = 16;  // of a spline through the polyline
          if (entity.flag(70, kFrame)) continue;
          vertices.push_back({point(entity, 10), entity(42, 0.0)});
          if (in_space(*polyline)) same_height(entity);
        } else if (polyline && entity.type == "SEQEND") {
          polyline_curve(*polyline, vertices);
          polyline.reset();
        } else if (entity.type == "POLYLINE") {
          polyline = entity;
          vertices.clear();
          height_.reset();
        } else {
          draw(entity);
        }
      } catch (const dxf::ShapeError& e) {
        throw UsageError(fmt::format("{}:{}: {}", name_, entity.line, e.what()));
      }
    }
    if (!more) fail("ends before EOF");
    if (code_ != 0) fail("ENTITIES must begin with an entity");
    if (polyline) fail("a POLYLINE without SEQEND");
    section_.clear();
  }

  Point2 point(const Entity& e, int code) const {
    return {unit_mm_ * e(code, 0.0), unit_mm_ * e(code + 10, 0.0)};
  }

  bool visible(const Entity& e) const {
    return e(60, 0.0) == 0.0 && e(67, 0.0) == 0.0 && hidden_.count(e.layer) == 0;
  }

  /// True if the entity's plane is the drawing's seen from below.
  bool mirrored(const Entity& e) const {
    constexpr double kClose = 1e-6;
    const double x = e(210, 0.0), y = e(220, 0.0), z = e(230, 1.0);
    if (std::abs(x) > kClose || std::abs(y) > kClose || std::abs(std::abs(z) - 1.0) > kClose)
      throw dxf::ShapeError(
          fmt::format("{} lies in a plane with normal {}, {}, {}: must be 0, 0, +-1", e.type, x, y, z));
    return z < 0.0;
  }

  /// True for a visible polyline whose vertices have heights of their own.
  bool in_space(const Entity& polyline) const { return polyline.flag(70, 8) && visible(polyline); }

  void same_height(const Entity& vertex) {
    const double z = vertex(30, 0.0);
    if (height_ && z != *height_) throw dxf::ShapeError("z changes along a path; it must be constant");
    height_ = z;
  }

  void draw(const Entity& e) {
    if (!visible(e)) return;
    const auto is = [&](std::string_view other) { return other == e.type; };
    if (std::any_of(kNotDrawn.begin(), kNotDrawn.end(), is)) return;
    DrawnCurve curve;
    bool mirror = false;
    if (is("LINE")) {
      if (e(30, 0.0) != e(31, 0.0)) throw dxf::ShapeError("z changes along a path; it must be constant");
      const dxf::Vertex ends[2] = {{point(e, 10)}, {point(e, 11)}};
      dxf::sample(ends, false, curve.shape);
    } else if (is("ARC") || is("CIRCLE")) {
      mirror = mirrored(e);
      const bool whole = is("CIRCLE");
      dxf::sample_arc(point(e, 10), unit_mm_ * e(40, 0.0), whole ? 0.0 : e(50, 0.0),
                      whole ? 360.0 : e(51, 0.0), curve.shape);
    } else if (is("ELLIPSE")) {
      constexpr double kWholeTurn = 6.283185307179586;
      dxf::sample_ellipse(point(e, 10), point(e, 11), e(40, 1.0), e(41, 0.0), e(42, kWholeTurn), mirrored(e),
                          curve.shape);
    } else if (is("LWPOLYLINE")) {
      mirror = mirrored(e);
      std::vector<dxf::Vertex> vertices;
      for (const Group& g : e.groups) {
        if (g.code == 10) vertices.push_back({{unit_mm_ * g.value, 0.0}});
        if (vertices.empty()) continue;
        if (g.code == 20) vertices.back().at.y_mm = unit_mm_ * g.value;
        if (g.code == 42) vertices.back().bulge = g.value;
      }
      dxf::sample(vertices, e.flag(70, 1), curve.shape);
    } else if (is("SPLINE")) {
      dxf::sample(spline(e), curve.shape);
    } else {
      throw dxf::ShapeError(
          fmt::format("{} is not read: {}; explode it, or switch its layer off", shown(e.type), kRead));
    }
    keep(std::move(curve), e, mirror, is("LWPOLYLINE") ? e(38, 0.0) : e(30, 0.0));
  }

  void polyline_curve(const Entity& e, const std::vector<dxf::Vertex>& vertices) {
    constexpr int kMesh = 16 | 64;
    const std::optional<double> height = height_;
    height_.reset();
    if (!visible(e)) return;
    if (e.flag(70, kMesh)) throw dxf::ShapeError("a POLYLINE that is a mesh is not read");
    DrawnCurve curve;
    dxf::sample(vertices, e.flag(70, 1), curve.shape);
    if (in_space(e))
      keep(std::move(curve), e, false, height.value_or(0.0));
    else
      keep(std::move(curve), e, mirrored(e), e(30, 0.0));
  }

  dxf::Spline spline(const Entity& e) const {
    dxf::Spline s;
    s.degree = int(std::clamp(e(71, 3.0), -1.0, 1000.0));
    std::optional<double> height;
    for (const Group& g : e.groups) {
      if (g.code == 40) s.knots.push_back(g.value);
      if (g.code == 41) s.weights.push_back(g.value);
      if (g.code == 10) s.control.push_back({unit_mm_ * g.value, 0.0});
      if (g.code == 20 && !s.control.empty()) s.control.back().y_mm = unit_mm_ * g.value;
      if (g.code != 30) continue;
      if (height && *height != g.value) throw dxf::ShapeError("z changes along a path; it must be constant");
      height = g.value;
    }
    return s;
  }

  void keep(DrawnCurve&& curve, const Entity& e, bool mirror, double height) {
    if (mirror) {
      for (Point2& p : curve.shape.points) p.x_mm = -p.x_mm;
      for (GivenCurve& given : curve.shape.given) {
        for (Point2* p : {&given.centre, &given.start, &given.control[0], &given.control[1], &given.end})
          p->x_mm = -p->x_mm;
        given.clockwise = !given.clockwise;
      }
    }
    curve.z_mm = unit_mm_ * (mirror ? -height : height);
    if (!(std::abs(curve.z_mm) <= kMaxCoordinate_mm))
      throw dxf::ShapeError(
          fmt::format("{} mm is beyond the limit of +-{} mm", curve.z_mm, kMaxCoordinate_mm));
    curve.line = e.line;
    curve.layer = e.layer;
    points_ += curve.shape.points.size();
    if (points_ > kMaxPathPoints)
      throw dxf::ShapeError(fmt::format("more than {} points in one drawing", kMaxPathPoints));
    if (curve.shape.points.size() > 1) curves_.push_back(std::move(curve));
  }

  std::istream& in_;
  const std::string& name_;
  const PathSink& sink_;
  std::string text_, value_, section_, variable_, layer_name_;
  std::set<std::string> hidden_;  ///< layers that are off or frozen
  std::vector<DrawnCurve> curves_;
  std::optional<double> height_;  ///< of the vertices of a polyline in space
  std::size_t line_ = 0, points_ = 0;
  double unit_mm_ = 1.0;
  int code_ = 0;
  bool section_begins_ = false, in_layer_ = false, layer_hidden_ = false;
};

}  // namespace

void read_paths_dxf(std::istream& in, const std::string& name, double, const PathSink& sink) {
  DxfReader(in, name, sink).read();
}

}  // namespace firn
