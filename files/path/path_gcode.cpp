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
#include <string_view>

#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kMaxGcodeLineBytes = 1000;
constexpr double kInch_mm = 25.4;
constexpr const char* kKnown = "G0 to G5, G17, G20, G21, G28, G30, G90 to G92 and F";
/// Codes that leave the path as it is, in tenths: no compensation, tool length (coordinates are the tip's),
/// coordinate system 1, path modes, no rotation, feed per minute, spindle speed, returns of drilling cycles.
constexpr std::array<int, 14> kHarmless{170, 400, 430, 431, 490, 540, 610, 611, 640, 690, 940, 970, 980, 990};
constexpr std::string_view kOtherAxes = "ABCUVW";

/// True for M codes of printers' firmware, whose words are no coordinates: M92 X80, M117 text, M201 X500.
bool takes_own_words(double code) {
  return code == 17.0 || code == 18.0 || (code >= 20.0 && code < 30.0) || code == 73.0 || code == 84.0 ||
         code == 92.0 || code >= 100.0;
}

class GcodeReader {
 public:
  GcodeReader(std::istream& in, const std::string& name, double size, const PathSink& sink)
      : in_(in), name_(name), size_(size), sink_(sink) {}

  void read() {
    std::string line;
    while (!ended_ && std::getline(in_, line)) {
      ++number_;
      bytes_ += double(line.size()) + 1.0;
      if (line.size() > kMaxGcodeLineBytes)
        fail(fmt::format("a line longer than the limit of {} bytes", kMaxGcodeLineBytes));
      std::string_view text = line;
      if (number_ == 1 && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
      block(text);
    }
    finish();
    if (paths_ == 0) fail("holds no path: a G1, G2, G3 or G5 is needed");
  }

 private:
  struct Words {
    std::array<std::optional<double>, 26> of{};
    std::optional<double>& operator[](char letter) { return of[std::size_t(letter - 'A')]; }
  };
  /// Requests of a block besides its modal codes.
  struct Asked {
    std::optional<int> motion;
    bool cancel = false, dwell = false, home = false, set_place = false;
  };

  [[noreturn]] void fail(const std::string& problem) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, number_, problem));
  }

  void block(std::string_view text) {
    Words words;
    Asked asked;
    bool first = true, stops = false;
    const auto skip_blanks = [&](std::size_t i) {
      while (i < text.size() && std::isspace(static_cast<unsigned char>(text[i]))) ++i;
      return i;
    };
    for (std::size_t i = skip_blanks(0); i < text.size(); i = skip_blanks(i)) {
      const char c = char(std::toupper(static_cast<unsigned char>(text[i])));
      if (c == ';' || c == '*') break;  // a comment, a checksum
      if (c == '%') {
        ended_ = begun_;
        begun_ = true;
        break;
      }
      if (c == '(') {
        i = text.find(')', i);
        if (i == text.npos) fail("a comment without its )");
        ++i;
        continue;
      }
      if (c == '/') {
        ++i;
        continue;
      }
      begun_ = true;
      if (c == '#' || c == '[') fail("parameters and expressions (#, [ ]) are not read");
      if (c < 'A' || c > 'Z') fail(fmt::format("'{}' is no word of G-code", c >= ' ' && c <= '~' ? c : '?'));
      const double value = number(c, text, i);
      if (c == 'M' && first && takes_own_words(value)) return;
      first = first && c == 'N';
      if (c == 'G') {
        code(value, asked);
      } else if (c == 'M') {
        stops = machine_code(value) || stops;
      } else {
        if (words[c] && (std::string_view("XYZIJKRF").find(c) != std::string_view::npos))
          fail(fmt::format("{} stands twice in one block", c));
        words[c] = value;
      }
    }
    carry_out(words, asked);
    if (stops) finish();
  }

  /// The number behind the letter at i; i is then behind it.
  double number(char letter, std::string_view text, std::size_t& i) const {
    const std::size_t from = i++;
    while (i < text.size() && (text[i] == ' ' || text[i] == '\t')) ++i;
    if (letter == 'O') refuse_call(text.substr(i));
    if (i < text.size() && (text[i] == '#' || text[i] == '['))
      fail("parameters and expressions (#, [ ]) are not read");
    if (i + 1 < text.size() && text[i] == '+' && text[i + 1] != '-') ++i;
    double value = 0.0;
    // without exponents: X1E2 is X1 E2
    const auto [end, error] =
        std::from_chars(text.data() + i, text.data() + text.size(), value, std::chars_format::fixed);
    if (error != std::errc() || !std::isfinite(value)) {
      std::string shown(text.substr(from, 20));
      std::replace_if(
          shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
      fail(fmt::format("{}: {} must be followed by a finite number", shown, letter));
    }
    i = std::size_t(end - text.data());
    return value;
  }

  /// O1000 names a program; with a word behind it, or a name, it calls or repeats a part of one.
  void refuse_call(std::string_view rest) const {
    std::size_t i = 0;
    while (i < rest.size() && (std::isdigit(static_cast<unsigned char>(rest[i])) || rest[i] == ' ')) ++i;
    if (i < rest.size() && (rest[i] == '<' || std::isalpha(static_cast<unsigned char>(rest[i]))))
      fail("O-words that call, repeat or choose are not read");
  }

  void code(double value, Asked& asked) {
    const int tenths = int(std::lround(std::clamp(10.0 * value, -1.0, 1e4)));
    const bool known = std::abs(10.0 * value - tenths) < 1e-6;
    if (known && (tenths == 0 || tenths == 10 || tenths == 20 || tenths == 30 || tenths == 50)) {
      if (asked.motion && *asked.motion != tenths / 10) fail("two motions in one block");
      motion_ = tenths / 10;
      asked.motion = motion_;
    } else if (known && tenths == 200) {
      unit_mm_ = kInch_mm;
    } else if (known && tenths == 210) {
      unit_mm_ = 1.0;
    } else if (known && (tenths == 900 || tenths == 910)) {
      relative_ = tenths == 910;
    } else if (known && (tenths == 901 || tenths == 911)) {
      absolute_centre_ = tenths == 901;
    } else if (known && tenths == 800) {
      asked.cancel = true;
    } else if (known && tenths == 40) {
      asked.dwell = true;
    } else if (known && (tenths == 280 || tenths == 300)) {
      asked.home = true;
    } else if (known && tenths == 920) {
      asked.set_place = true;
    } else if (known && (tenths == 921 || tenths == 922)) {
      shift_ = {};
      z_shift_mm_ = 0.0;
    } else if (!known || std::find(kHarmless.begin(), kHarmless.end(), tenths) == kHarmless.end()) {
      fail(fmt::format("G{:g} is not known here: {}", value, kKnown));
    }
  }

  /// Returns true for a code at which the program or the machine stops.
  bool machine_code(double value) {
    if (value == 98.0) fail("M98 calls a subprogram, which is not read");
    ended_ = ended_ || value == 2.0 || value == 30.0 || value == 99.0;
    return ended_ || value == 0.0 || value == 1.0 || value == 6.0 || value == 60.0;
  }

  void carry_out(Words& words, const Asked& asked) {
    if (words['F']) {
      if (!(*words['F'] > 0.0)) fail("F must be above 0");
      feed_mm_s_ = *words['F'] * unit_mm_ / 60.0;
    }
    if (asked.dwell) return finish();  // its words are seconds
    if (asked.home) return go_home(words);
    if (asked.set_place) return set_place(words);
    for (const char axis : kOtherAxes)
      if (words[axis].value_or(0.0) != 0.0)
        fail(fmt::format("{}{:g}: only the axes X, Y and Z are read", axis, *words[axis]));
    if (asked.cancel && !asked.motion) motion_ = kNoMotion;
    const bool straight = motion_ == 0 || motion_ == 1;
    const bool moves = words['X'] || words['Y'] || words['Z'] ||
                       (!straight && motion_ != kNoMotion && (words['I'] || words['J'] || words['R']));
    if (!moves) return;
    if (motion_ == kNoMotion) fail("a coordinate without G0, G1, G2, G3 or G5 after G80");
    move(words);
  }

  /// The machine's own place is not the program's: the next move with X and Y leads back into it.
  void go_home(Words& words) {
    finish();
    const bool all = !words['X'] && !words['Y'] && !words['Z'];
    lost_x_ = lost_x_ || all || words['X'];
    lost_y_ = lost_y_ || all || words['Y'];
    lost_z_ = lost_z_ || all || words['Z'];
  }

  /// G92: the present place gets other coordinates.
  void set_place(Words& words) {
    const auto set = [&](const std::optional<double>& word, double& now, double& shift, bool& lost) {
      if (!word) return;
      const double mm = *word * unit_mm_;
      if (!(std::abs(mm) <= kMaxCoordinate_mm))
        fail(fmt::format("{} mm is beyond the limit of +-{} mm", mm, kMaxCoordinate_mm));
      if (lost) now = mm;
      lost = false;
      shift = now - mm;
    };
    set(words['X'], at_.x_mm, shift_.x_mm, lost_x_);
    set(words['Y'], at_.y_mm, shift_.y_mm, lost_y_);
    set(words['Z'], z_mm_, z_shift_mm_, lost_z_);
  }

  double target(const std::optional<double>& word, double now, double shift) const {
    if (!word) return now;
    const double mm = *word * unit_mm_, value = relative_ ? now + mm : shift + mm;
    if (std::abs(value) > kMaxCoordinate_mm)
      fail(fmt::format("{} mm is beyond the limit of +-{} mm", value, kMaxCoordinate_mm));
    return value;
  }

  /// The first move after G28 only places the tool.
  void find_place(Words& words, Point2 to, double z) {
    if (relative_ && (words['X'] || words['Y']))
      fail("G91 after G28: the place is not known before X and Y are given with G90");
    if (motion_ > 1) fail("an arc or a spline after G28: the place is not known before a G0 with X and Y");
    finish();
    lost_x_ = lost_x_ && !words['X'];
    lost_y_ = lost_y_ && !words['Y'];
    lost_z_ = lost_z_ && (relative_ || !words['Z']);
    at_ = to;
    z_mm_ = z;
  }

  void move(Words& words) {
    const Point2 to{target(words['X'], at_.x_mm, shift_.x_mm), target(words['Y'], at_.y_mm, shift_.y_mm)};
    const double z = target(words['Z'], z_mm_, z_shift_mm_);
    if (lost_x_ || lost_y_ || (lost_z_ && words['Z'] && !relative_)) return find_place(words, to, z);
    if (motion_ != 5) spline_end_.reset();
    if (motion_ == 0 || (z != z_mm_ && to == at_ && motion_ == 1)) {
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
    if (words['P'].value_or(1.0) != 1.0) fail("an arc of several turns (P) is not read");
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
      if (absolute_centre_ && (!words['I'] || !words['J'])) fail("with G90.1 an arc needs both I and J");
      const Point2 origin = absolute_centre_ ? shift_ : at_;
      centre = {origin.x_mm + words['I'].value_or(0.0) * unit_mm_,
                origin.y_mm + words['J'].value_or(0.0) * unit_mm_};
      const double from = distance(centre, at_), end = distance(centre, to);
      if (!arc_radii_agree(from, end))
        fail(fmt::format("the arc's radius is {} mm at its start and {} mm at its end", from, end));
    }
    const std::size_t first = path_.path.points.size() - 1;
    const auto exact = sample_arc(at_, to, centre, side, [&](Point2 p) { add(p); });
    give_arc(exact, side, first, path_.path.points.size() - 1, path_.given);
  }

  /// Without I and J a spline goes on in the direction in which the one before it ended.
  void bezier(Words& words, Point2 to) {
    if (!words['P'] || !words['Q']) fail("G5 needs I, J, P and Q");
    if (bool(words['I']) != bool(words['J']) || (!words['I'] && !spline_end_))
      fail("G5 needs both I and J, or neither after another G5");
    const auto offset = [&](char letter) { return words[letter].value_or(0.0) * unit_mm_; };
    const Point2 first_offset =
        words['I'] ? Point2{offset('I'), offset('J')} : Point2{-spline_end_->x_mm, -spline_end_->y_mm};
    const Point2 b{at_.x_mm + first_offset.x_mm, at_.y_mm + first_offset.y_mm},
        c{to.x_mm + offset('P'), to.y_mm + offset('Q')};
    spline_end_ = Point2{offset('P'), offset('Q')};
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
  static constexpr int kNoMotion = -1;
  Point2 at_, shift_;                 ///< shift_: by G92, of the program's zero
  std::optional<Point2> spline_end_;  ///< P and Q of the G5 before
  double z_mm_ = 0.0, z_shift_mm_ = 0.0, unit_mm_ = 1.0, feed_mm_s_ = motion::kUnlimited, bytes_ = 0.0;
  int motion_ = 0;
  bool relative_ = false, absolute_centre_ = false;
  bool lost_x_ = false, lost_y_ = false, lost_z_ = false;  ///< since G28
  bool begun_ = false, ended_ = false;
  std::int64_t number_ = 0, paths_ = 0;
};

}  // namespace

void read_paths_gcode(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  GcodeReader(in, name, size, sink).read();
}

}  // namespace firn
