// JSON paths by events: the document is never held as a whole.
#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "cli/exit_codes.h"
#include "cli/path_file.h"
#include "config/fields.h"

namespace firn {
namespace {

const std::vector<std::string_view> kTopKeys{"version", "paths"};
const std::vector<std::string_view> kPathKeys{"layer",    "material", "kind", "closed", "width_mm", "layer_height_mm",
                                              "z_mm",     "yaw_deg",  "tool", "speed_mm_s", "points"};
const std::vector<std::string_view> kKinds{"boundary", "fill", "hook", "measurement"};  // in the order of PathKind

class Handler : public nlohmann::json_sax<nlohmann::json> {
 public:
  Handler(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  bool null() override {
    if (at_ == At::kPoint && coordinates_.size() == 2) return number(motion::kUnlimited);
    return wrong("null");
  }
  bool boolean(bool value) override {
    if (at_ != At::kPath || key_ != "closed") return wrong(value ? "true" : "false");
    path_.path.closed = value;
    return true;
  }
  bool number_integer(number_integer_t value) override { return whole(double(value)); }
  bool number_unsigned(number_unsigned_t value) override { return whole(double(value)); }
  bool number_float(number_float_t value, const string_t&) override { return number(value); }
  bool string(string_t& value) override {
    if (at_ == At::kPath && key_ == "tool") {
      if (value.empty() || value.size() > 40) fail("must be a name of 1 to 40 bytes");
      path_.tool = value;
    } else if (at_ == At::kPath && key_ == "kind") {
      const auto found = std::find(kKinds.begin(), kKinds.end(), value);
      if (found == kKinds.end()) {
        const std::string near = nearest(value, kKinds);
        fail(fmt::format("\"{}\"{} must be one of {}", value.substr(0, 40), near.empty() ? "" : " (did you mean \"" + near + "\"?)", list(kKinds)));
      }
      path_.path.kind = PathKind(found - kKinds.begin());
    } else {
      return wrong("a text");
    }
    return true;
  }
  bool binary(binary_t&) override { return wrong("binary"); }

  bool start_object(std::size_t) override {
    if (at_ == At::kRoot) at_ = At::kTop;
    else if (at_ == At::kPaths) begin_path();
    else return wrong("an object");
    return true;
  }
  bool key(string_t& value) override {
    const auto& known = at_ == At::kTop ? kTopKeys : kPathKeys;
    if (std::find(known.begin(), known.end(), value) == known.end()) {
      const std::string near = nearest(value, known);
      fail(fmt::format("{}: unknown key{}", value.substr(0, 60), near.empty() ? "; known: " + list(known) : "; the nearest known one is " + near));
    }
    key_ = value;
    return true;
  }
  bool end_object() override {
    if (at_ == At::kPath) finish_path();
    else if (!saw_paths_) fail("has no key \"paths\"");
    else key_.clear();
    return true;
  }
  bool start_array(std::size_t) override {
    if (at_ == At::kTop && key_ == "paths" && !saw_paths_) at_ = At::kPaths, saw_paths_ = true;
    else if (at_ == At::kPath && key_ == "points" && path_.path.points.empty()) at_ = At::kPoints;
    else if (at_ == At::kPoints) at_ = At::kPoint, coordinates_.clear();
    else return wrong("a list");
    return true;
  }
  bool end_array() override {
    if (at_ == At::kPoint) finish_point(), at_ = At::kPoints;
    else if (at_ == At::kPoints) at_ = At::kPath, key_.clear();
    else at_ = At::kTop, key_.clear();
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& e) override {
    std::string what = e.what();
    if (const std::size_t colon = what.rfind(": "); colon != what.npos) what = what.substr(colon + 2);
    throw UsageError(fmt::format("{}: byte {}: {}", name_, position, what.substr(0, 200)));
  }
  void finish() const {
    if (number_ == 0) throw UsageError(name_ + ": paths: holds no path");
  }

 private:
  enum class At { kRoot, kTop, kPaths, kPath, kPoints, kPoint };

  static std::string list(const std::vector<std::string_view>& words) {
    std::string out;
    for (std::string_view w : words) out += (out.empty() ? "" : ", ") + std::string(w);
    return out;
  }

  std::string where() const {
    switch (at_) {
      case At::kRoot: return "";
      case At::kTop: return key_;
      case At::kPaths: return "paths";
      case At::kPath: return fmt::format("paths[{}]{}{}", number_, key_.empty() ? "" : ".", key_);
      default: return fmt::format("paths[{}].points[{}]", number_, path_.path.points.size());
    }
  }
  [[noreturn]] void fail(const std::string& problem) const {
    const std::string place = where();
    throw UsageError(name_ + ": " + (place.empty() ? "" : place + ": ") + problem);
  }
  const char* expected() const {
    switch (at_) {
      case At::kRoot: return "the file must be an object {\"version\": 1, \"paths\": [...]}";
      case At::kTop: return key_ == "version" ? "must be 1" : "must be one list of paths";
      case At::kPaths: return "must be an object";
      case At::kPath:
        if (key_ == "closed") return "must be true or false";
        if (key_ == "tool" || key_ == "kind") return "must be a text";
        return key_ == "points" ? "must be one list of points" : "must be a number";
      default: return "must be [x_mm, y_mm] or [x_mm, y_mm, speed_mm_s]";
    }
  }
  bool wrong(const char* found) const { fail(fmt::format("{}, not {}", expected(), found)); }

  double between(double value, double low, double high, bool above_low = false) const {
    if (value <= high && (above_low ? value > low : value >= low)) return value;
    fail(fmt::format("{} must lie in {}{}, {}]", value, above_low ? "(" : "[", low, high));
  }
  bool whole(double value) {
    if (at_ == At::kTop && key_ == "version") {
      if (value != 1.0) fail(fmt::format("{} is unknown; this program reads version 1", value));
      return true;
    }
    if (at_ == At::kPath && key_ == "layer") path_.path.layer = std::int32_t(between(value, 0, 1e6));
    else if (at_ == At::kPath && key_ == "material") path_.path.material = std::uint8_t(between(value, 0, 255));
    else return number(value);
    return true;
  }
  bool number(double value) {
    if (at_ == At::kPoint) {
      if (coordinates_.size() == 3) return wrong("more numbers");
      coordinates_.push_back(value);
      return true;
    }
    if (at_ != At::kPath) return wrong("a number");
    if (key_ == "width_mm") path_.path.width_mm = between(value, 0, 1000);
    else if (key_ == "layer_height_mm") path_.path.layer_height_mm = between(value, 0, 1000);
    else if (key_ == "z_mm") path_.path.z_mm = between(value, -kMaxCoordinate_mm, kMaxCoordinate_mm);
    else if (key_ == "yaw_deg") path_.yaw_rad = between(value, -360, 360) * std::numbers::pi / 180.0;
    else if (key_ == "speed_mm_s") path_.ceiling.path_mm_s = between(value, 0, 1e6, true);
    else if (key_ == "layer" || key_ == "material") fail("must be a whole number");
    else return wrong("a number");
    return true;
  }

  void begin_path() {
    at_ = At::kPath;
    path_ = InputPath();
    path_.place = fmt::format("{}: paths[{}]", name_, number_);
    any_speed_ = false;
    key_.clear();
  }
  void finish_point() {
    if (coordinates_.size() < 2) wrong("fewer numbers");
    for (std::size_t n = 0; n < 2; ++n) between(coordinates_[n], -kMaxCoordinate_mm, kMaxCoordinate_mm);
    const double speed = coordinates_.size() == 3 ? coordinates_[2] : motion::kUnlimited;
    if (std::isfinite(speed)) between(speed, 0, 1e6, true), any_speed_ = true;
    if (path_.path.points.size() == kMaxPathPoints) fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    path_.path.points.push_back({coordinates_[0], coordinates_[1]});
    path_.ceiling.point_mm_s.push_back(speed);
  }
  void finish_path() {
    key_.clear();
    if (path_.path.points.empty()) fail("has no points");
    if (!any_speed_) path_.ceiling.point_mm_s.clear();
    path_.number = ++number_;
    const double at = double(in_.tellg());
    path_.fraction = size_ > 0.0 && at > 0.0 ? at / size_ : 0.0;
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
  bool any_speed_ = false, saw_paths_ = false;
  std::int64_t number_ = 0;  // finished paths = index of the one being read
};

}  // namespace

void read_paths_json(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  Handler handler(in, name, size, sink);
  nlohmann::json::sax_parse(in, &handler);
  handler.finish();
}

}  // namespace firn
