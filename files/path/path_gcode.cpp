// Reads paths from G-code: moves that deposit, one after another, are one path. A move that does not deposit
// ends it.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "files/path/feed_path.h"
#include "files/path/gcode_block.h"
#include "files/path/gcode_survey.h"
#include "files/path/path_file.h"
#include "files/path/sampled_shapes.h"
#include "files/text_lines.h"

namespace firn {
namespace {

using Material = GcodeSurvey::Material;

constexpr double kInch_mm = 25.4;
constexpr const char* kKnown =
    "G0 to G5, G10, G11, G17, G20, G21, G28, G30, G38, G53 to G59, G90 to G92 and F";
/// Codes that leave the path as it is, in tenths: no polar coordinates, plane XY, no compensation, tool
/// length (coordinates are the tip's), no scaling, path modes, no rotation, feed per minute, spindle speed,
/// returns of drilling cycles.
constexpr std::array<int, 15> kHarmless{150, 170, 400, 430, 431, 490, 500, 600,
                                        640, 690, 940, 970, 980, 990, 110};
/// Codes of printers at which the machine moves by itself: nozzle cleaning, park, bed probing, gantry
/// levelling.
constexpr std::array<int, 6> kRoutines{120, 270, 290, 320, 340, 350};
/// Codes of machine tools, in tenths, for messages.
constexpr std::pair<int, std::string_view> kRefused[] = {
    {160, "polar coordinates"}, {180, "the plane ZX"},        {190, "the plane YZ"},
    {330, "threading"},         {410, "cutter compensation"}, {420, "cutter compensation"},
    {510, "scaling"},           {520, "a local zero"},        {680, "a rotation"},
    {730, "a drilling cycle"},  {740, "a drilling cycle"},    {760, "a threading cycle"},
    {810, "a drilling cycle"},  {820, "a drilling cycle"},    {830, "a drilling cycle"},
    {840, "a tapping cycle"},   {850, "a boring cycle"},      {860, "a boring cycle"},
    {870, "a boring cycle"},    {880, "a boring cycle"},      {890, "a boring cycle"},
    {930, "inverse time feed"}, {950, "feed per revolution"}, {960, "constant surface speed"},
};
constexpr std::string_view kOtherAxes = "ABCUVW";

class GcodeReader {
 public:
  GcodeReader(std::istream& in, const std::string& name, double size, const PathSink& sink,
              const GcodeSurvey& survey)
      : lines_(in, name, kMaxGcodeLineBytes), name_(name), size_(size), sink_(sink), survey_(survey) {}

  void read() {
    const std::function<void(const std::string&)> fail = [this](const std::string& problem) {
      this->fail(problem);
    };
    std::string_view line;
    while (!ended_ && lines_.next(line)) block(read_gcode_block(line, survey_.exponent, fail));
    finish();
    if (paths_ == 0) fail_without_path();
    sink_.travelled(travel_mm_);
    note_material();
    note_passed_over();
    if (machine_moves_ > 0)
      sink_.note(fmt::format(
          "{}: {} move(s) in the machine's coordinates (G53) left out: the file does not say where the "
          "machine's zero is",
          name_, machine_moves_));
    if (empty_ > 0)
      sink_.note(
          fmt::format("{}: {} path(s) of length 0 left out, the first at {}", name_, empty_, first_empty_));
  }

 private:
  /// Requests of a block besides its modal codes.
  struct Asked {
    std::optional<int> motion;
    bool cancel = false, dwell = false, home = false, set_place = false, machine_place = false, probe = false;
  };
  struct Modes {
    bool relative = false, relative_e = false;
  };

  [[noreturn]] void fail(const std::string& problem) const { lines_.fail(problem); }

  [[noreturn]] void fail_without_path() const {
    if (survey_.material == Material::kExtruder)
      fail(
          "holds no path: no move in X and Y has a growing E (M82: E is absolute, which holds without M83, "
          "too)");
    if (survey_.material == Material::kBeam)
      fail("holds no path: no G1, G2, G3 or G5 comes while M3 or M4 holds and S is above 0");
    fail("holds no path: a G1, G2, G3 or G5 is needed" + passed_over("; passed over: "));
  }

  void note_material() const {
    if (survey_.material == Material::kMoves) return;
    sink_.note(fmt::format("{}: {:.2f} mm deposit, {:.2f} mm are travel: {}", name_, deposited_mm_,
                           travel_mm_,
                           survey_.material == Material::kExtruder ? "moves without a growing E"
                           : survey_.has_power                     ? "G0, and moves at S0 or without M3 or M4"
                                                                   : "G0, and moves without M3 or M4"));
  }
  std::string passed_over(const std::string& before) const {
    constexpr std::size_t kShown = 12;
    std::string all;
    std::size_t shown = 0;
    for (const auto& [command, count] : passed_)
      if (++shown <= kShown)
        all += (all.empty() ? before : ", ") + (count > 1 ? fmt::format("{} x ", count) : "") + command;
    if (shown > kShown) all += fmt::format(" and {} further commands", shown - kShown);
    return all;
  }
  void note_passed_over() const {
    if (!passed_.empty()) sink_.note(name_ + passed_over(": commands of the machine, passed over: "));
  }

  void block(const GcodeBlock& b) {
    if (b.percent) {
      ended_ = begun_;
      begun_ = true;
      return;
    }
    if (b.empty) return;
    begun_ = true;
    Asked asked;
    bool stops = false;
    for (const double g : b.g) code(g, b, asked);
    for (const double m : b.m) stops = machine_code(m) || stops;
    if (!b.command.empty()) command(b);
    carry_out(b, asked);
    if (stops) finish();
  }

  void code(double value, const GcodeBlock& b, Asked& asked) {
    const int tenths = int(std::lround(std::clamp(10.0 * value, -1.0, 1e4)));
    if (!(std::abs(10.0 * value - tenths) < 1e-6)) return unknown_code(value, -1);
    if (tenths == 0 || tenths == 10 || tenths == 20 || tenths == 30 || tenths == 50) {
      if (asked.motion && *asked.motion != tenths / 10) fail("two motions in one block");
      motion_ = tenths / 10;
      asked.motion = motion_;
    } else if (tenths == 100) {
      tool_table(b);
    } else if (tenths == 200 || tenths == 210) {
      unit_mm_ = tenths == 200 ? kInch_mm : 1.0;
    } else if (tenths == 900 || tenths == 910) {
      modes_.relative = tenths == 910;
    } else if (tenths == 901 || tenths == 911) {
      absolute_centre_ = tenths == 901;
    } else if (tenths == 800) {
      asked.cancel = true;
    } else if (tenths == 40) {
      asked.dwell = true;
    } else if (tenths == 280 || tenths == 300) {
      asked.home = true;
    } else if (tenths >= 382 && tenths <= 385) {
      asked.probe = true;
    } else if (tenths == 530) {
      asked.machine_place = true;
    } else if (tenths >= 540 && tenths <= 593 && (tenths % 10 == 0 || tenths > 590)) {
      choose_system(value, tenths);
    } else if (tenths == 610 || tenths == 611) {
      asked.home = saved_place_;  // printers return to the place that G60 saved
    } else if (tenths == 920) {
      asked.set_place = true;
    } else if (tenths == 921 || tenths == 922) {
      shift_ = {};
      z_shift_mm_ = 0.0;
    } else if (survey_.material == Material::kExtruder &&
               std::ranges::find(kRoutines, tenths) != kRoutines.end()) {
      ++passed_[fmt::format("G{:g}", value)];
      asked.home = true;
    } else if (std::ranges::find(kHarmless, tenths) == kHarmless.end()) {
      unknown_code(value, tenths);
    } else if (tenths == 600) {
      saved_place_ = survey_.material == Material::kExtruder;
    }
  }

  [[noreturn]] void unknown_code(double value, int tenths) const {
    const auto found = std::ranges::find(kRefused, tenths, &std::pair<int, std::string_view>::first);
    fail(fmt::format("G{:g}{} is not known here: {}", value,
                     found == std::end(kRefused) ? std::string() : fmt::format(" ({})", found->second),
                     kKnown));
  }

  /// G10 is the retraction of printers' firmware; with L it sets tables, of which the zeros move the path.
  void tool_table(const GcodeBlock& b) {
    if (b['L'] == 2.0 || b['L'] == 20.0)
      fail(fmt::format("G10 L{:g} sets the zero of a coordinate system, which is not read", *b['L']));
    if (!b['L'] && !b['P']) finish();
  }

  /// A zero of the machine's own: the coordinates mean the same as long as it stays one.
  void choose_system(double value, int tenths) {
    if (moved_ && tenths != system_)
      fail(fmt::format(
          "G{:g}: a second coordinate system, whose distance from the first the file does not say", value));
    system_ = tenths;
  }

  /// Returns true for a code at which the program or the machine stops.
  bool machine_code(double value) {
    ended_ = ended_ || value == 2.0 || value == 30.0 || value == 99.0;
    if (value == 3.0 || value == 4.0 || value == 5.0) on_ = value != 5.0;
    if (value == 82.0 || value == 83.0) modes_.relative_e = value == 83.0;
    return ended_ || value == 0.0 || value == 1.0 || value == 6.0 || value == 60.0 || value == 600.0;
  }

  void command(const GcodeBlock& b) {
    if (b.command == "M0" || b.command == "M1") return;
    ++passed_[b.command];
    const bool restore = b.command == "RESTORE_GCODE_STATE";
    if (b.command == "SAVE_GCODE_STATE") saved_modes_[std::string(b.arguments)] = modes_;
    if (restore && saved_modes_.contains(std::string(b.arguments)))
      modes_ = saved_modes_[std::string(b.arguments)];
    if (b.command == "$H" || (restore && b.arguments.find("MOVE=1") != b.arguments.npos))
      lose_place(true, true, true);
  }

  void carry_out(const GcodeBlock& b, const Asked& asked) {
    const bool spindle = b.has_m(3.0) || b.has_m(4.0) || b.has_m(5.0);
    if (!b.flag_text.empty() && !asked.home && !spindle)
      fail(fmt::format("{}: {} must be followed by a finite number", b.flag_text, b.flag_text.front()));
    if (b['F']) {
      if (!(*b['F'] > 0.0)) fail("F must be above 0");
      feed_mm_s_ = *b['F'] * unit_mm_ / 60.0;
    }
    if (asked.dwell) return finish();  // its words are seconds
    if (b['S']) power_ = *b['S'];
    if (asked.home) return lose_named(b);
    if (asked.set_place) return set_place(b);
    if (b['T'] && *b['T'] != tool_ && survey_.material == Material::kExtruder) finish();
    tool_ = b['T'].value_or(tool_);
    for (const char axis : kOtherAxes)
      if (b[axis].value_or(0.0) != 0.0)
        fail(fmt::format("{}{:g}: only the axes X, Y and Z are read", axis, *b[axis]));
    if (asked.cancel && !asked.motion) motion_ = kNoMotion;
    const bool grows = extrude(b);
    const bool straight = motion_ == 0 || motion_ == 1;
    const bool moves =
        b['X'] || b['Y'] || b['Z'] || (!straight && motion_ != kNoMotion && (b['I'] || b['J'] || b['R']));
    if (!moves) return;
    moved_ = true;
    if (asked.machine_place || asked.probe) return machine_move(b, asked.probe, grows);
    if (motion_ == kNoMotion) fail("a coordinate without G0, G1, G2, G3 or G5 after G80");
    move(b, deposits(grows));
  }

  /// Returns true if the block feeds material. A retraction ends the path.
  bool extrude(const GcodeBlock& b) {
    if (!b['E'] || survey_.material != Material::kExtruder) return false;
    constexpr double kNothing_mm = 1e-9;
    const double value = *b['E'] * unit_mm_;
    const double change = modes_.relative_e || modes_.relative ? value : value - e_mm_;
    e_mm_ += change;
    if (change < -kNothing_mm) finish();
    return change > kNothing_mm;
  }

  bool deposits(bool grows) const {
    if (survey_.material == Material::kExtruder) return grows;
    if (motion_ == 0) return false;
    if (survey_.material == Material::kMoves) return true;
    return (on_ || !survey_.switched) && (power_ > 0.0 || !survey_.has_power);
  }

  void lose_place(bool x, bool y, bool z) {
    finish();
    lost_x_ = lost_x_ || x;
    lost_y_ = lost_y_ || y;
    lost_z_ = lost_z_ || z;
  }

  /// The machine's own place is not the program's: the next move with X and Y leads back into it.
  void lose_named(const GcodeBlock& b) {
    const auto named = [&](char axis) { return b[axis] || b.flag[std::size_t(axis - 'A')]; };
    const bool all = !named('X') && !named('Y') && !named('Z');
    lose_place(all || named('X'), all || named('Y'), all || named('Z'));
  }

  /// A move in machine coordinates (G53) or up to a probe's contact (G38): where it ends is not known here.
  void machine_move(const GcodeBlock& b, bool probe, bool grows) {
    if (!probe && (b['X'] || b['Y']) && deposits(grows))
      fail("G53 with a move that deposits: the file does not say where the machine's zero is");
    if (!probe) ++machine_moves_;
    lose_place(bool(b['X']), bool(b['Y']), bool(b['Z']));
  }

  /// G92: the present place gets other coordinates.
  void set_place(const GcodeBlock& b) {
    if (!b['X'] && !b['Y'] && !b['Z'] && !b['E'] &&
        std::ranges::none_of(kOtherAxes, [&](char a) { return b[a].has_value(); }))
      fail("G92 without a coordinate: write those that become 0, as G92 X0 Y0 or G92 E0");
    const auto set = [&](const std::optional<double>& word, double& now, double& shift, bool& lost) {
      if (!word) return;
      const double mm = *word * unit_mm_;
      check_within(mm);
      if (lost) now = mm;
      lost = false;
      shift = now - mm;
    };
    set(b['X'], at_.x_mm, shift_.x_mm, lost_x_);
    set(b['Y'], at_.y_mm, shift_.y_mm, lost_y_);
    set(b['Z'], z_mm_, z_shift_mm_, lost_z_);
    if (b['E']) e_mm_ = *b['E'] * unit_mm_;
  }

  void check_within(double mm) const {
    if (!(std::abs(mm) <= kMaxCoordinate_mm))
      fail(fmt::format("{} mm is beyond the limit of +-{} mm", mm, kMaxCoordinate_mm));
  }

  double target(const std::optional<double>& word, double now, double shift) const {
    if (!word) return now;
    const double mm = *word * unit_mm_, value = modes_.relative ? now + mm : shift + mm;
    check_within(value);
    return value;
  }

  /// The first move after G28 only places the tool.
  void find_place(const GcodeBlock& b, Point2 to, double z) {
    if (modes_.relative && (b['X'] || b['Y']))
      fail("G91 after G28: the place is not known before X and Y are given with G90");
    if (motion_ > 1) fail("an arc or a spline after G28: the place is not known before a G0 with X and Y");
    finish();
    lost_x_ = lost_x_ && !b['X'];
    lost_y_ = lost_y_ && !b['Y'];
    lost_z_ = lost_z_ && (modes_.relative || !b['Z']);
    at_ = to;
    z_mm_ = z;
  }

  void move(const GcodeBlock& b, bool deposit) {
    const Point2 to{target(b['X'], at_.x_mm, shift_.x_mm), target(b['Y'], at_.y_mm, shift_.y_mm)};
    const double z = target(b['Z'], z_mm_, z_shift_mm_);
    const bool place_lost = lost_x_ || lost_y_ || (lost_z_ && b['Z'] && !modes_.relative);
    if (place_lost) return find_place(b, to, z);
    if (motion_ != 5) spline_end_.reset();
    if (!deposit || (z != z_mm_ && to == at_ && motion_ < 2)) {
      travel(b, to);
    } else {
      if (z != z_mm_) fail("z changes along a path; it must be constant");
      if (path_.empty()) path_.start(fmt::format("{}:{}", name_, lines_.number()), at_, z_mm_);
      draw(b, to, path_);
      if (path_.points() > kMaxPathPoints)
        fail(fmt::format("more than {} points in one path", kMaxPathPoints));
    }
    at_ = to;
    z_mm_ = z;
  }

  void travel(const GcodeBlock& b, Point2 to) {
    finish();
    FeedPath way;
    way.start({}, at_, z_mm_);
    draw(b, to, way);
    travel_mm_ += way.length_mm();
  }

  void draw(const GcodeBlock& b, Point2 to, FeedPath& path) {
    if (motion_ < 2)
      add(to, path);
    else if (motion_ == 5)
      bezier(b, to, path);
    else
      arc(b, to, path);
  }

  void add(Point2 p, FeedPath& path) const {
    check_within(p.x_mm);
    check_within(p.y_mm);
    path.add(p, feed_mm_s_);
  }

  /// True if two places are one, but for the rounding of the file's coordinates: a last decimal each. Files
  /// with fewer than two decimals are not rounded, but whole.
  bool coincide(Point2 a, Point2 b) const {
    constexpr double kExact_mm = 1e-6, kRoom = 1.001;
    const double last_mm = survey_.decimals >= 2 ? unit_mm_ * std::pow(10.0, -survey_.decimals) : 0.0;
    const double most = kRoom * std::max(kExact_mm, last_mm);
    return std::abs(a.x_mm - b.x_mm) <= most && std::abs(a.y_mm - b.y_mm) <= most;
  }

  void arc(const GcodeBlock& b, Point2 to, FeedPath& path) {
    const double side = motion_ == 3 ? 1.0 : -1.0;
    if (b['P'].value_or(1.0) != 1.0) fail("an arc of several turns (P) is not read");
    const Point2 centre = b['R'] ? centre_by_radius(b, to, side) : centre_by_offset(b, to);
    const Point2 end = !b['R'] && coincide(at_, to) ? at_ : to;  // a full circle
    const std::size_t first = path.points() - 1;
    const auto exact = sample_arc(at_, end, centre, side, [&](Point2 p) { add(p, path); });
    give_arc(exact, side, first, path.points() - 1, path.given());
  }

  Point2 centre_by_radius(const GcodeBlock& b, Point2 to, double side) const {
    const double r = *b['R'] * unit_mm_, chord = distance(at_, to);
    if (!(chord > 0.0) || (r < 0.0 && coincide(at_, to)))
      fail(fmt::format("a full circle of R{:g} has no known centre: a full circle needs I and J", *b['R']));
    const double height = r * r - 0.25 * chord * chord;
    if (height < -1e-6 * r * r || r == 0.0) fail(fmt::format("an arc of radius {} mm does not reach", r));
    const double away = std::sqrt(std::max(0.0, height)) * (r < 0.0 ? -side : side) / chord;
    return {0.5 * (at_.x_mm + to.x_mm) - away * (to.y_mm - at_.y_mm),
            0.5 * (at_.y_mm + to.y_mm) + away * (to.x_mm - at_.x_mm)};
  }

  Point2 centre_by_offset(const GcodeBlock& b, Point2 to) const {
    if (!b['I'] && !b['J']) fail("an arc needs I and J, or R");
    if (absolute_centre_ && (!b['I'] || !b['J'])) fail("with G90.1 an arc needs both I and J");
    const Point2 origin = absolute_centre_ ? shift_ : at_;
    const Point2 centre{origin.x_mm + b['I'].value_or(0.0) * unit_mm_,
                        origin.y_mm + b['J'].value_or(0.0) * unit_mm_};
    const double from = distance(centre, at_), end = distance(centre, to);
    if (!arc_radii_agree(from, end))
      fail(fmt::format("the arc's radius is {} mm at its start and {} mm at its end", from, end));
    return centre;
  }

  /// Without I and J a spline goes on in the direction in which the one before it ended.
  void bezier(const GcodeBlock& b, Point2 to, FeedPath& path) {
    if (!b['P'] || !b['Q']) fail("G5 needs I, J, P and Q");
    if (bool(b['I']) != bool(b['J']) || (!b['I'] && !spline_end_))
      fail("G5 needs both I and J, or neither after another G5");
    const auto offset = [&](char letter) { return b[letter].value_or(0.0) * unit_mm_; };
    const Point2 first_offset =
        b['I'] ? Point2{offset('I'), offset('J')} : Point2{-spline_end_->x_mm, -spline_end_->y_mm};
    const Point2 second{at_.x_mm + first_offset.x_mm, at_.y_mm + first_offset.y_mm},
        third{to.x_mm + offset('P'), to.y_mm + offset('Q')};
    spline_end_ = Point2{offset('P'), offset('Q')};
    const std::size_t first = path.points() - 1;
    const int samples = sample_bezier(at_, second, third, to, [&](Point2 p) { add(p, path); });
    give_bezier(at_, second, third, to, samples, first, path.points() - 1, path.given());
  }

  void finish() {
    if (path_.empty()) return;
    const bool drawn = path_.points() > 1;
    if (drawn) deposited_mm_ += path_.length_mm();
    InputPath path = path_.take();
    if (!drawn) {
      if (++empty_ == 1) first_empty_ = path.place;
      return;
    }
    path.number = ++paths_;
    path.fraction = lines_.fraction(size_);
    sink_(std::move(path));
  }

  TextLines lines_;
  const std::string& name_;
  double size_;
  const PathSink& sink_;
  GcodeSurvey survey_;
  FeedPath path_;
  std::map<std::string, int> passed_;  ///< commands that are no moves, and how many of each
  static constexpr int kNoMotion = -1;
  Point2 at_, shift_;                 ///< shift_: by G92, of the program's zero
  std::optional<Point2> spline_end_;  ///< P and Q of the G5 before
  double z_mm_ = 0.0, z_shift_mm_ = 0.0, unit_mm_ = 1.0, feed_mm_s_ = motion::kUnlimited, e_mm_ = 0.0,
         power_ = 0.0;
  double tool_ = 0.0, deposited_mm_ = 0.0, travel_mm_ = 0.0;
  int motion_ = 0, system_ = 540;
  Modes modes_;
  std::map<std::string, Modes> saved_modes_;  ///< by Klipper's SAVE_GCODE_STATE
  bool absolute_centre_ = false, on_ = false, moved_ = false, saved_place_ = false;
  bool lost_x_ = false, lost_y_ = false, lost_z_ = false;  ///< since G28
  bool begun_ = false, ended_ = false;
  std::int64_t paths_ = 0, empty_ = 0, machine_moves_ = 0;
  std::string first_empty_;  ///< FILE:LINE of the first path of length 0
};

}  // namespace

void read_paths_gcode(std::istream& in, const std::string& name, double size, const PathSink& sink) {
  const GcodeSurvey survey = survey_gcode(in, name);
  in.clear();
  in.seekg(0);
  GcodeReader(in, name, size, sink, survey).read();
}

}  // namespace firn
