// Reads paths from DXF: the curves of a drawing's model space, joined where their ends meet.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "files/path/dxf_document.h"
#include "files/path/dxf_shapes.h"
#include "files/path/fit_spline.h"
#include "files/path/join_curves.h"
#include "files/path/path_file.h"
#include "files/path/plane_transform.h"
#include "files/usage_error.h"

namespace firn {
namespace {

using dxf::Entity;
using dxf::ShapeError;

/// Entities that draw no curve: texts, fills, pictures, construction lines, views.
constexpr std::array<std::string_view, 33> kDxfPassedOver{
    "ACAD_TABLE",    "ARC_DIMENSION", "ARCALIGNEDTEXT",
    "ATTDEF",        "ATTRIB",        "DGNUNDERLAY",
    "DIMENSION",     "DWFUNDERLAY",   "GEOPOSITIONMARKER",
    "HATCH",         "IMAGE",         "LARGE_RADIAL_DIMENSION",
    "LEADER",        "LIGHT",         "MLEADER",
    "MPOLYGON",      "MTEXT",         "MULTILEADER",
    "OLE2FRAME",     "OLEFRAME",      "PDFUNDERLAY",
    "POINT",         "RAY",           "RTEXT",
    "SECTIONOBJECT", "SOLID",         "SUN",
    "TEXT",          "TOLERANCE",     "TRACE",
    "VIEWPORT",      "WIPEOUT",       "XLINE"};
constexpr const char* kDxfRead =
    "LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE, POLYLINE, SPLINE and INSERT are read";

constexpr double kDxfTurn = 2.0 * std::numbers::pi;

/// Heights nearer to 0 than this are rounding of the program that drew.
constexpr double kZeroHeight_mm = 1e-6;

constexpr std::size_t kMaxNestedBlocks = 64;
constexpr std::size_t kMaxInserts = 1000000;

/// Place of a block, or of the drawing itself.
struct BlockPlacement {
  PlaneTransform to_mm;
  double z_scale = 1.0, z_mm = 0.0;
  std::string layer;  ///< of the INSERT: entities of its block on layer 0 lie there
};

class DxfReader {
 public:
  DxfReader(dxf::Document&& document, const std::string& name, const PathSink& sink)
      : document_(std::move(document)), name_(name), sink_(sink) {}

  void read() {
    const double unit = document_.unit_mm;
    draw(document_.entities, {PlaneTransform::scaling(unit, unit), unit, 0.0, "0"});
    if (curves_.empty()) {
      const std::string what = left_out();
      throw UsageError(
          fmt::format("{}: holds no curve: {}{}{}", name_, kDxfRead, what.empty() ? "" : "; ", what));
    }
    tell();
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
  /// "passed over: 2 HATCH, 1 TEXT; 3 curves of length 0, the first in line 7".
  std::string left_out() const {
    std::string out;
    for (const auto& [type, count] : passed_over_)
      out += fmt::format("{}{} {}", out.empty() ? "passed over: " : ", ", count, type);
    if (empty_ > 0)
      out += fmt::format("{}{} of length 0 left out, the first in line {}", out.empty() ? "" : "; ", empty_,
                         first_empty_);
    return out;
  }

  void tell() const {
    if (document_.imperial)
      sink_.note(
          fmt::format("{}: $MEASUREMENT says imperial and no $INSUNITS names the unit: 1 unit is taken "
                      "as 1 mm; if it is an inch, set $INSUNITS to 1",
                      name_));
    if (const std::string what = left_out(); !what.empty()) sink_.note(name_ + ": " + what);
  }

  void draw(const std::vector<Entity>& entities, const BlockPlacement& at) {
    for (const Entity& e : entities) {
      try {
        draw(e, at);
      } catch (const ShapeError& error) {
        throw UsageError(fmt::format("{}:{}: {}", name_, e.line, error.what()));
      }
    }
  }

  const std::string& layer_of(const Entity& e, const BlockPlacement& at) const {
    return e.layer.empty() || e.layer == "0" ? at.layer : e.layer;
  }

  /// A block on a layer that is off shows its entities on other layers; on a frozen one it shows none.
  bool visible(const Entity& e, const std::string& layer) const {
    if (e(60, 0.0) != 0.0 || e(67, 0.0) != 0.0) return false;
    const auto found = document_.layers.find(layer);
    if (found == document_.layers.end()) return layer != "defpoints";
    return !found->second.frozen && (e.type == "INSERT" || !found->second.off);
  }

  /// True if the entity's plane is the drawing's seen from below.
  static bool mirrored(const Entity& e) {
    constexpr double kClose = 1e-6;
    const double x = e(210, 0.0), y = e(220, 0.0), z = e(230, 1.0);
    if (std::abs(x) > kClose || std::abs(y) > kClose || std::abs(std::abs(z) - 1.0) > kClose)
      throw ShapeError(
          fmt::format("{} lies in a plane with normal {}, {}, {}: must be 0, 0, +-1", e.type, x, y, z));
    return z < 0.0;
  }

  /// Places coordinates of the entity's own plane: seen from below, x and z change their sign.
  static BlockPlacement plane_of(const Entity& e, const BlockPlacement& at) {
    if (!mirrored(e)) return at;
    return {at.to_mm * PlaneTransform::scaling(-1.0, 1.0), -at.z_scale, at.z_mm, at.layer};
  }

  static Point2 point(const Entity& e, int code) { return {e(code, 0.0), e(code + 10, 0.0)}; }

  /// The one height of the values. @throws ShapeError if they differ
  static double height(std::initializer_list<double> values, const BlockPlacement& at) {
    const auto [low, high] = std::minmax(values);
    check_height(low, high, at);
    return *values.begin();
  }
  static void check_height(double low, double high, const BlockPlacement& at) {
    if (std::abs(at.z_scale * (high - low)) > kJoin_mm)
      throw ShapeError(fmt::format("z changes along a path, by {} mm; it must be constant within {} mm",
                                   std::abs(at.z_scale * (high - low)), kJoin_mm));
  }

  void draw(const Entity& e, const BlockPlacement& at) {
    const std::string& layer = layer_of(e, at);
    if (!visible(e, layer)) return;
    const std::string_view type = e.type;
    if (std::find(kDxfPassedOver.begin(), kDxfPassedOver.end(), type) != kDxfPassedOver.end()) {
      ++passed_over_[e.type];
      return;
    }
    if (type == "INSERT") return insert(e, at);
    ShapedPoints shape;
    BlockPlacement plane = at;
    double z = e(30, 0.0);
    if (type == "LINE") {
      z = height({z, e(31, 0.0)}, at);
      const dxf::Vertex ends[2] = {{point(e, 10)}, {point(e, 11)}};
      dxf::sample(ends, false, at.to_mm, shape);
    } else if (type == "ARC" || type == "CIRCLE") {
      plane = plane_of(e, at);
      dxf::sample(circle(e), plane.to_mm, shape);
    } else if (type == "ELLIPSE") {
      dxf::sample(ellipse(e), at.to_mm, shape);
    } else if (type == "LWPOLYLINE") {
      plane = plane_of(e, at);
      z = e(38, 0.0);
      dxf::sample(vertices(e), e.flag(70, 1), plane.to_mm, shape);
    } else if (type == "POLYLINE") {
      polyline(e, at, plane, z, shape);
    } else if (type == "SPLINE") {
      z = spline(e, at, shape);
    } else {
      throw ShapeError(fmt::format("\"{}\" is not read: {}; explode it, or switch its layer off",
                                   printable(type), kDxfRead));
    }
    keep(std::move(shape), e, layer, plane.z_scale * z + plane.z_mm);
  }

  static std::string printable(std::string_view text) {
    std::string out(text.substr(0, 40));
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return out;
  }

  static dxf::Arc circle(const Entity& e) {
    const double radius = e(40, 0.0);
    if (!(radius > 0.0)) throw ShapeError(fmt::format("a radius of {}; it must be above 0", radius));
    constexpr double kDegree = std::numbers::pi / 180.0;
    dxf::Arc arc{point(e, 10), {radius, 0.0}, {0.0, radius}, 0.0, kDxfTurn};
    if (e.type == "CIRCLE") return arc;
    arc.from = kDegree * e(50, 0.0);
    arc.to = kDegree * e(51, 0.0);
    arc.rounding = kDegree * std::min(e.place(50), e.place(51));
    return arc;
  }

  static dxf::Arc ellipse(const Entity& e) {
    const Point2 major = point(e, 11);
    const double ratio = e(40, 1.0), side = mirrored(e) ? -ratio : ratio;
    if (!(distance({}, major) > 0.0)) throw ShapeError("a major axis of 0; it must be above 0");
    if (!(ratio > 0.0 && ratio <= 1.0))
      throw ShapeError(fmt::format("a ratio of axes of {}; it must lie in (0, 1]", ratio));
    return {point(e, 10), major,           {-side * major.y_mm, side * major.x_mm},
            e(41, 0.0),   e(42, kDxfTurn), std::min(e.place(41), e.place(42))};
  }

  static std::vector<dxf::Vertex> vertices(const Entity& e) {
    std::vector<dxf::Vertex> out;
    for (const dxf::Group& g : e.groups) {
      if (g.code == 10) out.push_back({{g.value, 0.0}});
      if (out.empty()) continue;
      if (g.code == 20) out.back().at.y_mm = g.value;
      if (g.code == 42) out.back().bulge = g.value;
    }
    return out;
  }

  static void polyline(const Entity& e, const BlockPlacement& at, BlockPlacement& plane, double& z,
                       ShapedPoints& shape) {
    constexpr int kMesh = 16 | 64, kInSpace = 8;
    if (e.flag(70, kMesh)) throw ShapeError("a POLYLINE that is a mesh is not read");
    std::vector<dxf::Vertex> out;
    out.reserve(e.vertices.size());
    for (const dxf::PolylineVertex& v : e.vertices) out.push_back({v.at, v.bulge});
    if (!e.flag(70, kInSpace)) {
      plane = plane_of(e, at);
    } else if (!e.vertices.empty()) {
      const auto [low, high] = std::minmax_element(e.vertices.begin(), e.vertices.end(),
                                                   [](const auto& a, const auto& b) { return a.z < b.z; });
      check_height(low->z, high->z, at);
      z = e.vertices.front().z;
    }
    dxf::sample(out, e.flag(70, 1), plane.to_mm, shape);
  }

  /// Returns the spline's height.
  static double spline(const Entity& e, const BlockPlacement& at, ShapedPoints& shape) {
    dxf::Spline s;
    std::vector<Point2> fit;
    std::vector<double> heights;
    EndTangents tangents;
    s.degree = int(std::clamp(e(71, 3.0), -1.0, 1000.0));
    for (const dxf::Group& g : e.groups) {
      if (g.code == 40) s.knots.push_back(g.value);
      if (g.code == 41) s.weights.push_back(g.value);
      if (g.code == 10) s.control.push_back({g.value, 0.0});
      if (g.code == 20 && !s.control.empty()) s.control.back().y_mm = g.value;
      if (g.code == 11) fit.push_back({g.value, 0.0});
      if (g.code == 21 && !fit.empty()) fit.back().y_mm = g.value;
      if (g.code == 12) tangents.start = Point2{g.value, e(22, 0.0)};
      if (g.code == 13) tangents.end = Point2{g.value, e(23, 0.0)};
    }
    const int height_code = s.control.empty() ? 31 : 30;
    for (const dxf::Group& g : e.groups)
      if (g.code == height_code) heights.push_back(g.value);
    if (!heights.empty()) {
      const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
      check_height(*low, *high, at);
    }
    if (s.control.empty() && !fit.empty()) {
      check_fit(fit, tangents);
      dxf::sample(fit_spline(fit, e.flag(70, 1), tangents), at.to_mm, shape);
    } else {
      for (Point2& p : s.control) p = at.to_mm(p);
      dxf::sample(s, shape);
    }
    return heights.empty() ? 0.0 : heights.front();
  }

  static void check_fit(const std::vector<Point2>& fit, const EndTangents& tangents) {
    constexpr double kMax = 1e12;
    const auto check = [&](Point2 p) {
      if (!(std::abs(p.x_mm) <= kMax && std::abs(p.y_mm) <= kMax))
        throw ShapeError(
            fmt::format("a SPLINE with the point or tangent {}, {}: beyond +-{}", p.x_mm, p.y_mm, kMax));
    };
    for (const Point2& p : fit) check(p);
    for (const auto& t : {tangents.start, tangents.end})
      if (t) check(*t);
  }

  void insert(const Entity& e, const BlockPlacement& at) {
    const auto found = document_.blocks.find(e.block);
    if (found == document_.blocks.end())
      throw ShapeError(
          fmt::format("INSERT of block \"{}\", which the file does not define", printable(e.block)));
    const dxf::Block& block = found->second;
    if (block.external)
      throw ShapeError(
          fmt::format("INSERT of block \"{}\", which is drawn in another file: bind it", printable(e.block)));
    if (std::find(open_.begin(), open_.end(), &block) != open_.end())
      throw ShapeError(fmt::format("block \"{}\" inserts itself", printable(e.block)));
    if (open_.size() == kMaxNestedBlocks)
      throw ShapeError(fmt::format("blocks nested deeper than {}", kMaxNestedBlocks));
    const double sx = e(41, 1.0), sy = e(42, 1.0), sz = e(43, 1.0);
    if (sx == 0.0 || sy == 0.0) throw ShapeError("INSERT with a scale of 0");
    const auto count = [&](int code) {
      constexpr double kMaxCount = 32767.0;  // a 16-bit number of the format
      const double n = e(code, 1.0);
      if (n > kMaxCount)
        throw ShapeError(fmt::format("INSERT of {} rows or columns; at most {}", n, kMaxCount));
      return std::max(1, int(n));
    };
    const int columns = count(70), rows = count(71);
    const BlockPlacement plane = plane_of(e, at);
    const PlaneTransform turned =
        PlaneTransform::translation(e(10, 0.0), e(20, 0.0)) * PlaneTransform::rotation_deg(e(50, 0.0));
    const PlaneTransform sized =
        PlaneTransform::scaling(sx, sy) * PlaneTransform::translation(-block.base.x_mm, -block.base.y_mm);
    open_.push_back(&block);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        if (++inserts_ > kMaxInserts)
          throw ShapeError(fmt::format("more than {} blocks inserted", kMaxInserts));
        const auto cell = PlaneTransform::translation(column * e(44, 0.0), row * e(45, 0.0));
        draw(block.entities, {plane.to_mm * turned * cell * sized, plane.z_scale * sz,
                              plane.z_scale * (e(30, 0.0) - sz * block.z) + plane.z_mm, layer_of(e, at)});
      }
    open_.pop_back();
  }

  void keep(ShapedPoints&& shape, const Entity& e, const std::string& layer, double z_mm) {
    if (!(std::abs(z_mm) <= kMaxCoordinate_mm))
      throw ShapeError(fmt::format("{} mm is beyond the limit of +-{} mm", z_mm, kMaxCoordinate_mm));
    points_ += shape.points.size();
    if (points_ > kMaxPathPoints)
      throw ShapeError(fmt::format("more than {} points in one drawing", kMaxPathPoints));
    if (shape.points.size() < 2) {
      if (empty_++ == 0) first_empty_ = e.line;
      return;
    }
    curves_.push_back({std::move(shape), std::abs(z_mm) < kZeroHeight_mm ? 0.0 : z_mm, layer, e.line});
  }

  const dxf::Document document_;
  const std::string& name_;
  const PathSink& sink_;
  std::vector<DrawnCurve> curves_;
  std::map<std::string, std::size_t> passed_over_;
  std::vector<const dxf::Block*> open_;  ///< blocks that are being drawn, each within the one before
  std::size_t points_ = 0, inserts_ = 0, empty_ = 0, first_empty_ = 0;
};

}  // namespace

void read_paths_dxf(std::istream& in, const std::string& name, double, const PathSink& sink) {
  DxfReader(dxf::read_document(in, name), name, sink).read();
}

}  // namespace firn
