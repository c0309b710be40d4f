// JSON paths by events: the document is never held as a whole.
#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/options/enumerators.h"
#include "files/json.h"
#include "files/nearest.h"
#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"
#include "files/usage_error.h"

namespace firn {
namespace {

const std::vector<std::string_view> kTopKeys{"version", "paths"};
const std::vector<std::string_view> kPathKeys{"layer",    "material",        "kind",  "closed",
                                              "width_mm", "layer_height_mm", "z_mm",  "yaw_deg",
                                              "tool",     "speed_mm_s",      "points"};
const std::vector<std::string_view> kShapeKeys{"to", "centre", "clockwise", "control"};
constexpr std::array<std::string_view, 4> kKinds{"boundary", "fill", "hook", "measurement"};
static_assert(kKinds.size() == kTableSize<PathKind>);

constexpr double kDegree = std::numbers::pi / 180.0;

class Handler : public nlohmann::json_sax<nlohmann::json> {
 public:
  Handler(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  bool null() override {
    if (!in_point() || coordinates_.size() != 2) wrong("null");
    number(motion::kUnlimited);
    return true;
  }
  bool boolean(bool value) override {
    if (at_ == At::kShape && key_ == "clockwise")
      shape_.clockwise = value;
    else if (at_ == At::kPath && key_ == "closed")
      path_.path.closed = value;
    else
      wrong(value ? "true" : "false");
    return true;
  }
  bool number_integer(std::int64_t value) override {
    integer(double(value));
    return true;
  }
  bool number_unsigned(std::uint64_t value) override {
    integer(double(value));
    return true;
  }
  bool number_float(double value, const std::string& text) override {
    // An integer of more than 64 bits comes here too.
    text.find_first_of(".eE") == text.npos ? integer(value) : number(value);
    return true;
  }
  bool string(std::string& value) override {
    if (at_ == At::kPath && key_ == "tool") {
      if (value.empty() || value.size() > 40) fail("must be a name of 1 to 40 bytes");
      path_.tool = value;
    } else if (at_ == At::kPath && key_ == "kind") {
      const auto found = std::find(kKinds.begin(), kKinds.end(), value);
      if (found == kKinds.end()) {
        const std::vector<std::string_view> kinds(kKinds.begin(), kKinds.end());
        const std::string near = nearest(value, kinds);
        fail(fmt::format("\"{}\"{} must be one of {}", value.substr(0, 40),
                         near.empty() ? "" : " (did you mean \"" + near + "\"?)", list(kinds)));
      }
      path_.path.kind = PathKind(found - kKinds.begin());
    } else {
      wrong("a text");
    }
    return true;
  }

  bool start_object(std::size_t) override {
    if (at_ == At::kRoot)
      at_ = At::kTop;
    else if (at_ == At::kPaths)
      begin_path();
    else if (at_ == At::kPoints && !path_.path.points.empty()) {
      at_ = At::kShape;
      shape_ = {};
      key_.clear();
    } else
      wrong("an object");
    return true;
  }
  bool key(std::string& value) override {
    const auto& known = at_ == At::kTop ? kTopKeys : at_ == At::kShape ? kShapeKeys : kPathKeys;
    if (std::find(known.begin(), known.end(), value) == known.end()) {
      const std::string near = nearest(value, known);
      fail(fmt::format("{}: unknown key{}", value.substr(0, 60),
                       near.empty() ? "; known: " + list(known) : "; the nearest known one is " + near));
    }
    key_ = value;
    return true;
  }
  bool end_object() override {
    if (at_ == At::kPath)
      finish_path();
    else if (at_ == At::kShape)
      finish_shape();
    else if (!saw_paths_)
      fail("has no key \"paths\"");
    else
      key_.clear();
    return true;
  }
  bool start_array(std::size_t) override {
    if (at_ == At::kTop && key_ == "paths" && !saw_paths_) {
      at_ = At::kPaths;
      saw_paths_ = true;
    } else if (at_ == At::kPath && key_ == "points" && path_.path.points.empty())
      at_ = At::kPoints;
    else if (at_ == At::kPoints) {
      at_ = At::kPoint;
      coordinates_.clear();
    } else if (at_ == At::kShape && !key_.empty() && key_ != "clockwise") {
      at_ = At::kShapeNumbers;
      coordinates_.clear();
    } else if (at_ == At::kPath && key_ == "yaw_deg" && path_.yaw_point_rad.empty())
      at_ = At::kYaws;
    else
      wrong("a list");
    return true;
  }
  bool end_array() override {
    if (at_ == At::kPoint) {
      finish_point();
      at_ = At::kPoints;
    } else if (at_ == At::kShapeNumbers) {
      finish_shape_numbers();
      at_ = At::kShape;
    } else if (at_ == At::kPoints || at_ == At::kYaws) {
      at_ = At::kPath;
      key_.clear();
    } else {
      at_ = At::kTop;
      key_.clear();
    }
    return true;
  }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool parse_error(std::size_t byte, const std::string&, const nlohmann::json::exception& e) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 12: …": the byte says it for a file of
    // one line too
    const std::string_view what = e.what();
    const std::size_t place = what.find(": "), code = what.find("] ");
    throw UsageError(
        fmt::format("{}: byte {}: {}", name_, byte, what.substr(place < what.npos ? place + 2 : code + 2)));
  }
  void finish() const {
    if (number_ == 0) throw UsageError(name_ + ": paths: holds no path");
  }

 private:
  enum class At { kRoot, kTop, kPaths, kPath, kPoints, kPoint, kShape, kShapeNumbers, kYaws };

  /// {"to": …, "centre": …} or {"to": …, "control": …}
  struct Shape {
    std::vector<double> to, centre, control;
    bool clockwise = false;
  };

  static std::string list(const std::vector<std::string_view>& words) {
    std::string out;
    for (std::string_view w : words) out += (out.empty() ? "" : ", ") + std::string(w);
    return out;
  }

  std::string where() const {
    switch (at_) {
      case At::kRoot:
        return "";
      case At::kTop:
        return key_;
      case At::kPaths:
        return "paths";
      case At::kPath:
        return fmt::format("paths[{}]{}{}", number_, key_.empty() ? "" : ".", key_);
      case At::kYaws:
        return fmt::format("paths[{}].yaw_deg[{}]", number_, path_.yaw_point_rad.size());
      default:
        return fmt::format("paths[{}].points[{}]", number_, path_.path.points.size());
    }
  }
  [[noreturn]] void fail(const std::string& problem) const {
    const std::string place = where();
    throw UsageError(name_ + ": " + (place.empty() ? "" : place + ": ") + problem);
  }
  const char* expected() const {
    switch (at_) {
      case At::kRoot:
        return "the file must be an object {\"version\": 1, \"paths\": [...]}";
      case At::kTop:
        return key_ == "version" ? "must be 1" : "must be one list of paths";
      case At::kPaths:
        return "must be an object";
      case At::kPath:
        if (key_ == "closed") return "must be true or false";
        if (key_ == "tool" || key_ == "kind") return "must be a text";
        if (key_ == "yaw_deg") return "must be a number, or one list with a number per point";
        return key_ == "points" ? "must be one list of points" : "must be a number";
      case At::kYaws:
        return "must be a number";
      case At::kShape:
        if (key_ == "clockwise") return "clockwise must be true or false";
        return "must be {\"to\": [x_mm, y_mm], \"centre\": [x_mm, y_mm], \"clockwise\": false} or {\"to\": "
               "[x_mm, y_mm], \"control\": [x_mm, y_mm, x_mm, y_mm]}";
      case At::kShapeNumbers:
        if (key_ == "control") return "control must be [x_mm, y_mm, x_mm, y_mm]";
        if (key_ == "centre") return "centre must be [x_mm, y_mm]";
        [[fallthrough]];
      default:
        return "must be [x_mm, y_mm] or [x_mm, y_mm, speed_mm_s]";
    }
  }
  [[noreturn]] void wrong(const char* found) const { fail(fmt::format("{}, not {}", expected(), found)); }

  void integer(double value) {
    if (at_ == At::kTop && key_ == "version") {
      if (value != 1.0) fail(fmt::format("{} is unknown; this program reads version 1", value));
    } else if (at_ == At::kPath && key_ == "layer") {
      path_.path.layer = std::int32_t(between(value, 0, 1e6));
    } else if (at_ == At::kPath && key_ == "material") {
      path_.path.material = std::uint8_t(between(value, 0, 255));
    } else {
      number(value);
    }
  }
  void number(double value) {
    if (at_ == At::kPoint || at_ == At::kShapeNumbers) {
      if (coordinates_.size() == (in_point() ? 3u : shape_numbers())) wrong("more numbers");
      coordinates_.push_back(value);
      return;
    }
    if (at_ == At::kYaws) {
      if (path_.yaw_point_rad.size() == kMaxPathPoints)
        fail(fmt::format("more than {} entries", kMaxPathPoints));
      path_.yaw_point_rad.push_back(between(value, -kMaxYaw_deg, kMaxYaw_deg) * kDegree);
      return;
    }
    if (at_ != At::kPath) wrong("a number");
    if (key_ == "width_mm")
      path_.path.width_mm = between(value, 0, 1000);
    else if (key_ == "layer_height_mm")
      path_.path.layer_height_mm = between(value, 0, 1000);
    else if (key_ == "z_mm")
      path_.path.z_mm = between(value, -kMaxCoordinate_mm, kMaxCoordinate_mm);
    else if (key_ == "yaw_deg")
      path_.yaw_rad = between(value, -360, 360) * kDegree;
    else if (key_ == "speed_mm_s")
      path_.speed_limit.path_mm_s = between(value, 0, 1e6, true);
    else if (key_ == "layer" || key_ == "material")
      fail("must be a whole number");
    else
      wrong("a number");
  }

  double between(double value, double low, double high, bool above_low = false) const {
    if (value <= high && (above_low ? value > low : value >= low)) return value;
    fail(fmt::format("{} must lie in {}{}, {}]", value, above_low ? "(" : "[", low, high));
  }

  void begin_path() {
    at_ = At::kPath;
    path_ = InputPath();
    path_.place = fmt::format("{}: paths[{}]", name_, number_);
    any_speed_ = shaped_ = false;
    key_.clear();
  }
  /// True where the numbers being read are a point with or without its speed.
  bool in_point() const { return at_ == At::kPoint || (at_ == At::kShapeNumbers && key_ == "to"); }
  std::size_t shape_numbers() const { return key_ == "control" ? 4 : 2; }

  void add(Point2 p, double speed) {
    between(p.x_mm, -kMaxCoordinate_mm, kMaxCoordinate_mm);
    between(p.y_mm, -kMaxCoordinate_mm, kMaxCoordinate_mm);
    if (path_.path.points.size() == kMaxPathPoints)
      fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    path_.path.points.push_back(p);
    path_.speed_limit.point_mm_s.push_back(speed);
  }
  double speed_of(const std::vector<double>& point) {
    const double speed = point.size() == 3 ? point[2] : motion::kUnlimited;
    if (std::isfinite(speed)) {
      between(speed, 0, 1e6, true);
      any_speed_ = true;
    }
    return speed;
  }
  void finish_point() {
    if (coordinates_.size() < 2) wrong("fewer numbers");
    add({coordinates_[0], coordinates_[1]}, speed_of(coordinates_));
  }
  void finish_shape_numbers() {
    if (coordinates_.size() < shape_numbers()) wrong("fewer numbers");
    (key_ == "to" ? shape_.to : key_ == "centre" ? shape_.centre : shape_.control) = coordinates_;
  }
  void finish_shape() {
    key_.clear();
    if (shape_.to.empty() || shape_.centre.empty() == shape_.control.empty()) wrong("that");
    const Point2 from = path_.path.points.back(), to{shape_.to[0], shape_.to[1]};
    const double speed = speed_of(shape_.to);
    for (const std::vector<double>* numbers : {&shape_.centre, &shape_.control})
      for (const double v : *numbers) between(v, -kMaxCoordinate_mm, kMaxCoordinate_mm);
    const auto put = [&](Point2 p) { add(p, speed); };
    const std::size_t first = path_.path.points.size() - 1;
    const auto last = [&] { return path_.path.points.size() - 1; };
    if (shape_.control.empty()) {
      const Point2 centre{shape_.centre[0], shape_.centre[1]};
      const double start = distance(centre, from), end = distance(centre, to);
      if (!arc_radii_agree(start, end))
        fail(fmt::format("the arc's radius is {} mm at its start and {} mm at its end", start, end));
      const double side = shape_.clockwise ? -1.0 : 1.0;
      const auto exact = sample_arc(from, to, centre, side, put);
      give_arc(exact, side, first, last(), path_.given);
    } else {
      const std::vector<double>& c = shape_.control;
      const Point2 b{c[0], c[1]}, d{c[2], c[3]};
      const int samples = sample_bezier(from, b, d, to, put);
      give_bezier(from, b, d, to, samples, first, last(), path_.given);
    }
    shaped_ = true;
    at_ = At::kPoints;
  }
  void finish_path() {
    key_.clear();
    if (path_.path.points.empty()) fail("has no points");
    if (shaped_ && !path_.yaw_point_rad.empty())
      fail("a yaw_deg per point is not for paths with arcs or splines");
    if (const std::size_t yaws = path_.yaw_point_rad.size(); yaws > 0 && yaws != path_.path.points.size())
      fail(fmt::format("yaw_deg has {} entries, points {}", yaws, path_.path.points.size()));
    if (!any_speed_) path_.speed_limit.point_mm_s.clear();
    path_.number = ++number_;
    path_.fraction = size_ > 0.0 ? double(in_.tellg()) / size_ : 0.0;
    sink_(std::move(path_));
    at_ = At::kPaths;
  }

  std::istream& in_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  At at_ = At::kRoot;
  std::string key_;
  InputPath path_;
  std::vector<double> coordinates_;
  Shape shape_;
  bool any_speed_ = false, saw_paths_ = false, shaped_ = false;
  std::int64_t number_ = 0;  // finished paths = index of the one being read
};

}  // namespace

void read_paths_json(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  Handler handler(in, name, size, sink);
  nlohmann::json::sax_parse(in, &handler);
  handler.finish();
}

}  // namespace firn
