// Reads paths from G-code: the moves G1, G2, G3 and G5 between two G0 are one path.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <numbers>
#include <optional>
#include <string>

#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMaxGcodeLineBytes = 1000;
constexpr double kInch_mm = 25.4;
constexpr const char* kKnown = "G0 to G3, G5, G17, G20, G21, G90, G91 and F";
/// Codes that leave the path as it is: dwell, no compensation, coordinate system 1, path modes, feed per
/// minute.
constexpr std::array<int, 9> kHarmless{40, 400, 490, 540, 610, 640, 800, 940, 980};

class GcodeReader {
 public:
  GcodeReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  void read() {
    std::string line;
    while (std::getline(in_, line)) {
      ++number_;
      bytes_ += double(line.size()) + 1.0;
      if (line.size() > kMaxGcodeLineBytes)
        fail(fmt::format("a line longer than the limit of {} bytes", kMaxGcodeLineBytes));
      block(line);
    }
    finish();
    if (paths_ == 0) fail("holds no path: a G1, G2, G3 or G5 is needed");
  }

 private:
  struct Words {
    std::array<std::optional<double>, 26> of{};
    std::optional<double>& operator[](char letter) { return of[std::size_t(letter - 'A')]; }
  };

  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, number_, problem));
  }

  void block(std::string_view text) {
    Words words;
    bool moves = false;
    for (std::size_t i = 0; i < text.size();) {
      const char c = char(std::toupper(static_cast<unsigned char>(text[i])));
      if (c == ';' || c == '%') break;
      if (c == '(') {
        i = text.find(')', i);
        if (i == text.npos) fail("a comment without its )");
        ++i;
        continue;
      }
      if (std::isspace(static_cast<unsigned char>(c)) || c == '/') {
        ++i;
        continue;
      }
      if (c < 'A' || c > 'Z') fail(fmt::format("'{}' is no word of G-code", c >= ' ' && c <= '~' ? c : '?'));
      const std::size_t from = ++i;
      if (i < text.size() && text[i] == '+') ++i;
      double value = 0.0;
      const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
      if (error != std::errc() || !std::isfinite(value))
        fail(fmt::format("{}{}: is not a finite number", c, text.substr(from, 20)));
      i = std::size_t(end - text.data());
      if (c == 'G') {
        code(value);
      } else if (c == 'M' && (value == 2.0 || value == 30.0)) {
        finish();
      } else {
        words[c] = value;
        moves = moves || c == 'X' || c == 'Y' || c == 'Z' || c == 'I' || c == 'J' || c == 'R';
      }
    }
    if (words['F']) {
      if (!(*words['F'] > 0.0)) fail("F must be above 0");
      feed_mm_s_ = *words['F'] * unit_mm_ / 60.0;
    }
    if (moves) move(words);
  }

  void code(double value) {
    const int tenths = int(std::lround(std::clamp(10.0 * value, -1.0, 1e4)));
    if (tenths == 0 || tenths == 10 || tenths == 20 || tenths == 30 || tenths == 50) {
      motion_ = tenths / 10;
    } else if (tenths == 200) {
      unit_mm_ = kInch_mm;
    } else if (tenths == 210) {
      unit_mm_ = 1.0;
    } else if (tenths == 900 || tenths == 910) {
      relative_ = tenths == 910;
    } else if (tenths != 170 && std::find(kHarmless.begin(), kHarmless.end(), tenths) == kHarmless.end()) {
      fail(fmt::format("G{:g} is not known here: {}", value, kKnown));
    }
  }

  double target(const std::optional<double>& word, double now) const {
    if (!word) return now;
    const double mm = *word * unit_mm_, value = relative_ ? now + mm : mm;
    if (std::abs(value) > kMaxCoordinate_mm)
      fail(fmt::format("{} mm is beyond the limit of +-{} mm", value, kMaxCoordinate_mm));
    return value;
  }

  void move(Words& words) {
    const Point2 to{target(words['X'], at_.x_mm), target(words['Y'], at_.y_mm)};
    const double z = target(words['Z'], z_mm_);
    if (motion_ == 0 || (z != z_mm_ && to == at_)) {
      finish();
      at_ = to;
      z_mm_ = z;
      return;
    }
    if (z != z_mm_) fail("z changes along a path; it must be constant");
    if (path_.path.points.empty()) start();
    if (motion_ == 1) {
      add(to);
    } else if (motion_ == 5) {
      bezier(words, to);
    } else {
      arc(words, to);
    }
    at_ = to;
    if (path_.path.points.size() > kMaxPathPoints)
      fail(fmt::format("more than {} points in one path", kMaxPathPoints));
  }

  void start() {
    path_.place = fmt::format("{}:{}", name_, number_);
    path_.path.z_mm = z_mm_;
    path_.path.points.push_back(at_);
    feeds_.clear();
  }

  void add(Point2 p) {
    for (const double v : {p.x_mm, p.y_mm})
      if (!(std::abs(v) <= kMaxCoordinate_mm))
        fail(fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
    if (p == path_.path.points.back()) return;
    path_.path.points.push_back(p);
    feeds_.push_back(feed_mm_s_);
  }

  void arc(Words& words, Point2 to) {
    const double side = motion_ == 3 ? 1.0 : -1.0;
    Point2 centre;
    if (words['R']) {
      const double r = *words['R'] * unit_mm_, chord = distance(at_, to);
      const double height = r * r - 0.25 * chord * chord;
      if (!(chord > 0.0) || height < -1e-6 * r * r)
        fail(fmt::format("an arc of radius {} mm does not reach", r));
      const double away = std::sqrt(std::max(0.0, height)) * (r < 0.0 ? -side : side) / chord;
      centre = {0.5 * (at_.x_mm + to.x_mm) - away * (to.y_mm - at_.y_mm),
                0.5 * (at_.y_mm + to.y_mm) + away * (to.x_mm - at_.x_mm)};
    } else {
      if (!words['I'] && !words['J']) fail("an arc needs I and J, or R");
      centre = {at_.x_mm + words['I'].value_or(0.0) * unit_mm_,
                at_.y_mm + words['J'].value_or(0.0) * unit_mm_};
      const double from = distance(centre, at_), end = distance(centre, to);
      if (!arc_radii_agree(from, end))
        fail(fmt::format("the arc's radius is {} mm at its start and {} mm at its end", from, end));
    }
    const std::size_t first = path_.path.points.size() - 1;
    const auto exact = sample_arc(at_, to, centre, side, [&](Point2 p) { add(p); });
    give_arc(exact, side, first, path_.path.points.size() - 1, path_.given);
  }

  void bezier(Words& words, Point2 to) {
    const auto offset = [&](char letter) { return words[letter].value_or(0.0) * unit_mm_; };
    if (!words['P'] || !words['Q']) fail("G5 needs I, J, P and Q");
    const Point2 b{at_.x_mm + offset('I'), at_.y_mm + offset('J')},
        c{to.x_mm + offset('P'), to.y_mm + offset('Q')};
    const std::size_t first = path_.path.points.size() - 1;
    const int samples = sample_bezier(at_, b, c, to, [&](Point2 p) { add(p); });
    give_bezier(at_, b, c, to, samples, first, path_.path.points.size() - 1, path_.given);
  }

  /// A speed limit holds up to the next point: where the feed changes, a point on the faster line near the
  /// end confines the slower one.
  void part_feeds() {
    constexpr double kBeside_mm = 0.5;
    const std::vector<Point2> points = std::move(path_.path.points);
    const std::vector<double> feeds = std::move(feeds_);
    path_.path.points = {points.front()};
    feeds_.clear();
    std::vector<std::size_t> moved{0};  // where each point is now
    for (std::size_t i = 0; i < feeds.size(); ++i) {
      const Point2 &a = points[i], &b = points[i + 1];
      const double length = distance(a, b);
      const auto put = [&](Point2 p) {
        path_.path.points.push_back(p);
        feeds_.push_back(feeds[i]);
      };
      const auto at = [&](double s) {
        return Point2{a.x_mm + s / length * (b.x_mm - a.x_mm), a.y_mm + s / length * (b.y_mm - a.y_mm)};
      };
      const bool parts = length > 4.0 * kBeside_mm;  // no chord of an arc or a spline
      if (parts && i > 0 && feeds[i - 1] < feeds[i]) put(at(kBeside_mm));
      if (parts && i + 1 < feeds.size() && feeds[i + 1] < feeds[i]) put(at(length - kBeside_mm));
      put(b);
      moved.push_back(path_.path.points.size() - 1);
    }
    for (GivenCurve& curve : path_.given) {
      curve.first = moved[curve.first];
      curve.last = moved[curve.last];
    }
  }

  void finish() {
    if (path_.path.points.size() > 1) {
      if (std::any_of(feeds_.begin(), feeds_.end(), [](double f) { return f < motion::kUnlimited; })) {
        part_feeds();
        auto& speed = path_.speed_limit.point_mm_s;
        speed.assign(1, feeds_.front());
        for (std::size_t i = 0; i < feeds_.size(); ++i)
          speed.push_back(i + 1 < feeds_.size() ? std::min(feeds_[i], feeds_[i + 1]) : feeds_[i]);
      }
      path_.number = ++paths_;
      path_.fraction = size_ > 0.0 ? std::min(1.0, bytes_ / size_) : 0.0;
      sink_(std::move(path_));
    }
    path_ = InputPath();
  }

  std::istream& in_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  InputPath path_;
  std::vector<double> feeds_;  ///< of each segment [mm/s]
  Point2 at_;
  double z_mm_ = 0.0, unit_mm_ = 1.0, feed_mm_s_ = motion::kUnlimited, bytes_ = 0.0;
  int motion_ = 0;
  bool relative_ = false;
  std::int64_t number_ = 0, paths_ = 0;
};

}  // namespace

void read_paths_gcode(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  GcodeReader(in, name, size, sink).read();
}

}  // namespace firn
