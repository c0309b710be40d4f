// Computes a valve's latency from the places of its drops, and its flow at each frequency.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "config/ice_lab.h"
#include "core/grid/random.h"
#include "core/statistics/median.h"
#include "estimators/calibration/deposition.h"
#include "estimators/surface/path_readings.h"
#include "studies/calibrate/calibration_lab.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn {
namespace {

using calibration::FlowWeighing;
using calibration::LaidMark;
using surface::SurfacePoint;

constexpr double kValveLatencyTolerance_s = 0.002, kFlowTolerance = 0.02;
const char* section_of(int material) { return material == 1 ? "valve_b" : "valve_a"; }
const char* tool_of(int material) { return material == 1 ? "scaffold" : "water"; }

// --- valve latency
// -------------------------------------------------------------------------------------------------

constexpr double kGap_mm = 2.0;  // nozzle over the table: drops scatter in proportion
constexpr double kScanAbove_mm = 3.0;
constexpr double kScan_mm_s = 15.0;
constexpr double kFirst_mm = 42.0,
                 kMiddle_mm = 0.0;  // of the line's drops along x, of the lines along y: where the arm
                                    // reaches well; gaps of 7, 8, ... mm, so that a shifted row fits nowhere
constexpr int kDrops = 8;
constexpr double kLines_mm = 5.0;  // between lines
constexpr double kValveRunUp_s = 0.6;
constexpr double kMinDrop_mm = 0.06;     // of height
constexpr double kNear_mm = 1.0;         // a drop belongs to a mark
constexpr double kValveReach_mm = 12.0;  // maximum distance of a mark from its commanded place

std::vector<double> marks_of_line() {
  std::vector<double> at{kFirst_mm};
  for (int k = 0; k + 1 < kDrops; ++k) at.push_back(at.back() + 7.0 + k);
  return at;
}

/// Places of the tool along x at the trajectory's ticks.
std::vector<SurfacePoint> places(const CalibrationLab& lab, const Trajectory& motion,
                                 const motion::Tool& tool) {
  const Experiment& e = lab.experiment();
  const auto arm = make_arm(lab.machine());
  const std::vector<float> none(motion.samples(), 0.0F);
  std::vector<SurfacePoint> at;
  surface::add_readings(motion, {*arm, tool, {e.ice.origin_x_mm, e.ice.origin_y_mm}, e.ice.origin_z_mm, 0.0},
                        motion.tick_s, none, at);
  return at;
}

struct Line {
  double y_mm = 0.0, speed_mm_s = 0.0;  ///< signed
  std::vector<double> commanded_mm;     ///< commanded nozzle place at each pulse's tick
};

/// Runs one line with a pulse as the nozzle passes each mark.
Line lay(CalibrationLab& lab, int material, double table_mm, double y_mm, double speed_mm_s,
         RandomStream& random) {
  const std::vector<double> marks = marks_of_line();
  const double run_up = 10.0 + kValveRunUp_s * std::abs(speed_mm_s) + random.uniform(0.0, 12.0);
  const double low = marks.front() - run_up, high = marks.back() + run_up;
  LabPass pass;
  pass.tool = lab.tool(tool_of(material));
  pass.z_mm = table_mm + kGap_mm;
  pass.speed_mm_s = std::abs(speed_mm_s) * random.uniform(0.9, 1.0);
  pass.points = speed_mm_s > 0.0 ? std::vector<Point2>{{low, y_mm}, {high, y_mm}}
                                 : std::vector<Point2>{{high, y_mm}, {low, y_mm}};
  const Trajectory motion = lab.plan(pass);
  const std::vector<SurfacePoint> at = places(lab, motion, pass.tool);
  const double tick_s = list_limits(lab.machine(), lab.experiment()).tick_s;
  const auto x_at = [&](double t_s) {
    const double k = std::clamp(t_s / motion.tick_s, 0.0, double(at.size() - 1));
    const std::size_t i = std::min(std::size_t(k), at.size() - 2);
    return at[i].x_mm + (k - double(i)) * (at[i + 1].x_mm - at[i].x_mm);
  };
  Line line{y_mm, std::copysign(pass.speed_mm_s, speed_mm_s), {}};
  std::vector<std::int32_t> ticks;
  const double way = speed_mm_s > 0.0 ? 1.0 : -1.0;
  std::vector<double> order = marks;
  if (way < 0.0) std::reverse(order.begin(), order.end());
  for (std::int32_t tick = 1; tick * tick_s < motion.certificate.duration_s && ticks.size() < order.size();
       ++tick)
    if (way * (x_at(tick * tick_s) - order[ticks.size()]) >= 0.0) {
      ticks.push_back(tick);
      line.commanded_mm.push_back(x_at(tick * tick_s));
    }
  const std::int64_t counted = lab.fire(motion, material, ticks);
  if (counted != std::int64_t(ticks.size()))
    throw calibration::Unidentifiable(
        fmt::format("the valve has counted {} of {} pulses", counted, ticks.size()));
  return line;
}

/// Returns the middles of the drops along one line, from a pass there and one back, which cancel the laser's
/// own latency.
std::vector<double> drops_on(CalibrationLab& lab, int material, double table_mm, double y_mm) {
  const std::vector<double> marks = marks_of_line();
  const Experiment& e = lab.experiment();
  const auto arm = make_arm(lab.machine());
  std::vector<std::vector<double>> found;
  for (const bool forward : {true, false}) {
    LabPass pass;
    pass.tool = lab.tool("laser");
    pass.z_mm = table_mm + kScanAbove_mm;
    pass.speed_mm_s = kScan_mm_s;
    const double low = marks.front() - kValveReach_mm - 6.0, high = marks.back() + kValveReach_mm + 6.0;
    pass.points = forward ? std::vector<Point2>{{low, y_mm}, {high, y_mm}}
                          : std::vector<Point2>{{high, y_mm}, {low, y_mm}};
    const Trajectory motion = lab.plan(pass);
    const std::vector<float> reading = lab.scan(motion, material);
    std::vector<SurfacePoint> points;
    surface::add_readings(
        motion,
        {*arm, pass.tool, {e.ice.origin_x_mm, e.ice.origin_y_mm}, e.ice.origin_z_mm, e.laser_point.latency_s},
        1.0 / e.laser_point.rate_hz, reading, points);
    std::sort(points.begin(), points.end(),
              [](const SurfacePoint& a, const SurfacePoint& b) { return a.x_mm < b.x_mm; });
    // A drop is the height above the median of 4 mm about it; its middle is its volume's centroid.
    std::vector<double> middles, window;
    double sum = 0.0, moment = 0.0, last = -1e9;
    const auto close = [&] {
      if (sum > 0.0) middles.push_back(moment / sum);
      sum = moment = 0.0;
    };
    for (std::size_t i = 0, a = 0, b = 0; i < points.size(); ++i) {
      while (points[a].x_mm < points[i].x_mm - 3.0) ++a;
      while (b < points.size() && points[b].x_mm <= points[i].x_mm + 3.0) ++b;
      window.clear();
      for (std::size_t k = a; k < b; ++k) window.push_back(points[k].z_mm);
      const double up = points[i].z_mm - statistics::upper_median(window);
      if (up < kMinDrop_mm) continue;
      if (points[i].x_mm - last > kNear_mm) close();
      sum += up;
      moment += up * points[i].x_mm;
      last = points[i].x_mm;
    }
    close();
    found.push_back(std::move(middles));
  }
  std::vector<double> out;
  for (const double x : found[0]) {
    const auto near = std::min_element(found[1].begin(), found[1].end(),
                                       [&](double a, double b) { return std::abs(a - x) < std::abs(b - x); });
    if (near != found[1].end() && std::abs(*near - x) < 2.0 * kNear_mm) out.push_back(0.5 * (x + *near));
  }
  return out;
}

/// Returns the mean distance of the drops from their marks, at the shift common to most of them. Drops of a
/// line share their jet's lean, so a line is one datum. NaN: fewer than half were found.
double shift_of(const Line& line, const std::vector<double>& drops) {
  double best = std::nan(""), best_off = 0.0;
  std::size_t most = 0;
  for (double shift = -kValveReach_mm; shift <= kValveReach_mm; shift += 0.25) {
    std::size_t hits = 0;
    double sum = 0.0, off = 0.0;
    for (const double c : line.commanded_mm)
      for (const double x : drops)
        if (std::abs(x - c - shift) < kNear_mm) {
          ++hits;
          sum += x - c;
          off += std::abs(x - c - shift);
        }
    if (hits > most || (hits == most && hits > 0 && off < best_off)) {
      most = hits;
      best = sum / double(hits);
      best_off = off;
    }
  }
  return 2 * most >= line.commanded_mm.size() ? best : std::nan("");
}

// --- flow curve
// ----------------------------------------------------------------------------------------------------

constexpr double kWanted_mm3 = 400.0, kShortest_s = 12.0, kLongest_s = 40.0;
constexpr int kIdleWeighings = 20;
constexpr double kRest_s = 10.0;  // between weighings
constexpr double
    kWarmth_s = 200.0,
    kSlower_s = 300.0;  // a solenoid's coil warms in minutes; how many the fit finds between and about these
constexpr std::size_t kGapClasses = 6;
constexpr double kCupHeight_mm = 20.0;

/// Returns the ticks of a constant frequency on the list's raster: each pulse at the tick nearest to its
/// time, the later one of two (at 250 Hz every time lies between two: round-off must not choose).
std::vector<std::int32_t> even_ticks(double hz, double seconds, double tick_s) {
  std::vector<std::int32_t> ticks;
  for (std::int64_t k = 0;; ++k) {
    const auto tick = std::int32_t(std::floor((double(k) + 0.5) / hz / tick_s + 1e-6));
    if (tick * tick_s >= seconds) return ticks;
    ticks.push_back(tick);
  }
}

std::vector<double> gap_shares(const std::vector<std::int32_t>& ticks) {
  std::vector<double> share(kGapClasses, 0.0);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const std::size_t gap = k == 0 ? kGapClasses : std::size_t(ticks[k] - ticks[k - 1]);
    share[std::min(gap, kGapClasses) - 1] += 1.0 / double(ticks.size());
  }
  return share;
}

/// Computes the mean pulse rate of the last minutes, with a forgetting time constant of tau_s.
class Warmth {
 public:
  explicit Warmth(double tau_s) : tau_s_(tau_s) {}
  /// @returns the mean over the firing, in thousands of pulses a second
  double fired(double from_s, double to_s, double hz) {
    rest_until(from_s);
    const double before = now_, d = to_s - from_s, keep = std::exp(-d / tau_s_);
    now_ = hz + (before - hz) * keep;
    at_s_ = to_s;
    return 1e-3 * (hz + (before - hz) * tau_s_ / d * (1.0 - keep));
  }

 private:
  void rest_until(double t_s) {
    now_ *= std::exp(-(t_s - at_s_) / tau_s_);
    at_s_ = t_s;
  }
  double tau_s_, now_ = 0.0, at_s_ = 0.0;
};

}  // namespace

LabCalibration calibrate_valve_latency(const Experiment& experiment, const std::string& machine_toml,
                                       const LabCalibrationOptions& o) {
  using namespace lab_calibrations;
  const int repeats = o.repeats > 0 ? o.repeats : 4;
  const std::vector<double> speeds = o.speeds_mm_s.empty() ? std::vector<double>{40.0, 110.0} : o.speeds_mm_s;
  std::vector<std::pair<double, double>> wanted;  // y, signed speed
  for (int n = 0; n < repeats; ++n)
    for (const double s : speeds)
      for (const double way : {1.0, -1.0}) wanted.emplace_back(0.0, way * s);
  RandomStream random(o.seed, Purpose::kInstrument);
  for (std::size_t n = wanted.size(); n > 1; --n)
    std::swap(wanted[n - 1].second, wanted[random.below(std::uint32_t(n))].second);
  const double first = kMiddle_mm - 0.5 * kLines_mm * double(wanted.size() - 1);
  for (std::size_t n = 0; n < wanted.size(); ++n) wanted[n].first = first + kLines_mm * double(n);
  const std::vector<double> marks = marks_of_line();
  const double width = marks.back() - marks.front() + 2.0 * kValveReach_mm + 10.0;
  CalibrationLab lab(with_field(experiment, marks.front() - kValveReach_mm - 5.0, first - 5.0, width,
                                kLines_mm * double(wanted.size()) + 10.0),
                     machine_toml);
  lab.get_ready();
  const double table_mm = lab.surface_mm(0.5 * (marks.front() + marks.back()), kMiddle_mm);
  std::vector<Line> lines;
  const double steps = 3.0 * double(wanted.size());
  for (const auto& [y, speed] : wanted) {
    lines.push_back(lay(lab, o.material, table_mm, y, speed, random));
    if (o.progress) o.progress(double(lines.size()) / steps);
  }
  std::vector<LaidMark> data;
  LabCalibration out;
  std::size_t lost = 0;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const std::vector<double> drops = drops_on(lab, o.material, table_mm, lines[n].y_mm);
    const double shift = shift_of(lines[n], drops);
    if (std::isfinite(shift))
      data.push_back({0.0, shift, lines[n].speed_mm_s});
    else
      ++lost;
    if (o.progress) o.progress((double(lines.size()) + 2.0 * double(n + 1)) / steps);
  }
  if (2 * data.size() < lines.size())
    throw calibration::Unidentifiable(fmt::format(
        "of {} lines of drops only {} were found: is laser_point.offset_* calibrated, is there liquid?",
        lines.size(), data.size()));
  const calibration::ValveLatency v = calibration::calibrate_valve_latency(data);
  const double believed = (o.material == 1 ? experiment.valve_b : experiment.valve_a).latency_s;
  out.what = "valve-latency";
  out.keys = {{section_of(o.material),
               "latency_s",
               "s",
               {v.latency_s.value},
               {v.latency_s.ci95_half_width},
               {believed},
               5,
               false,
               kValveLatencyTolerance_s}};
  out.also.emplace_back("nozzle along x beyond the machine's, with the laser's own error [mm]", v.offset_mm);
  out.lines.push_back(
      fmt::format("{} lines of {} single drops laid both ways, found by passes of the laser both ways{}",
                  lines.size(), kDrops, lost ? fmt::format("; {} lines were not found", lost) : ""));
  out.data = v.fit.data;
  out.outliers = v.fit.outliers;
  out.residual_std = v.fit.residual_std;
  out.residual_unit = "mm";
  out.plot = {"speed [mm/s]", "line of drops off the fit [mm]", {{"a line", {}, {}}}};
  for (std::size_t n = 0; n < data.size(); ++n) {
    out.plot.groups[0].x.push_back(data[n].speed_mm_s);
    out.plot.groups[0].y.push_back(v.off_mm[n]);
  }
  out.lab_s = lab.now_s();
  check_intervals(out);
  return out;
}

LabCalibration calibrate_flow_curve(const Experiment& experiment, const std::string& machine_toml,
                                    const LabCalibrationOptions& o) {
  using namespace lab_calibrations;
  const CalibrationConfig& c = experiment.calibration;
  std::vector<double> frequencies = o.frequencies_hz;
  CalibrationLab lab(with_field(experiment, c.cup_x_mm - 200.0, c.cup_y_mm - 5.0, 10.0, 10.0), machine_toml,
                     o.weigh);
  const double tick_s = list_limits(lab.machine(), experiment).tick_s;
  if (frequencies.empty())
    for (int k = 1; k <= 20; ++k) frequencies.push_back(k / (20.0 * tick_s));
  for (const double hz : frequencies)
    if (!(hz >= 1.0 && hz * tick_s <= 1.0 + 1e-9))
      throw std::invalid_argument(
          fmt::format("{} Hz is not within 1 and {} Hz, a pulse a tick", hz, 1.0 / tick_s));
  calibration::check_flow_frequencies(frequencies);  // before an hour of weighing
  const int repeats = o.repeats > 0 ? o.repeats : 4;
  std::vector<double> order;
  RandomStream random(o.seed, Purpose::kInstrument, 1);
  for (int n = 0; n < repeats; ++n) {
    std::vector<double> turn = frequencies;
    for (std::size_t k = turn.size(); k > 1; --k)
      std::swap(turn[k - 1], turn[random.below(std::uint32_t(k))]);
    order.insert(order.end(), turn.begin(), turn.end());
  }
  lab.get_ready();
  LabPass over_cup;
  over_cup.tool = lab.tool(tool_of(o.material));
  over_cup.z_mm = kCupHeight_mm;
  over_cup.points = {{c.cup_x_mm, c.cup_y_mm}};
  const ValveLineConfig& valve = o.material == 1 ? experiment.valve_b : experiment.valve_a;
  const double density = o.material == 1 ? c.density_sme_mg_mm3 : c.density_water_mg_mm3;
  Warmth coil(kWarmth_s), slower(kSlower_s);
  std::vector<FlowWeighing> weighings;
  std::vector<double> idle_mg;  // no material is added: the scatter of the balance
  for (int n = 0; n < kIdleWeighings; ++n) idle_mg.push_back(lab.weigh_mg(o.material));
  double before_mg = std::accumulate(idle_mg.begin(), idle_mg.end(), 0.0) / kIdleWeighings,
         idle_squares = 0.0;
  for (const double mg : idle_mg) idle_squares += (mg - before_mg) * (mg - before_mg);
  const double balance_mm3 = std::sqrt(2.0 * idle_squares / (kIdleWeighings - 1)) / density;
  for (const double hz : order) {
    const double seconds = std::clamp(kWanted_mm3 * valve.hz_per_mm3_s / hz, kShortest_s, kLongest_s);
    const std::vector<std::int32_t> ticks = even_ticks(hz, seconds, tick_s);
    const double from_s = lab.now_s(), before_degC = lab.tip_degC();
    const std::int64_t counted = lab.fire(lab.stand(over_cup, seconds + 0.1), o.material, ticks);
    if (counted != std::int64_t(ticks.size()))
      throw calibration::Unidentifiable(
          fmt::format("the valve has counted {} of {} pulses", counted, ticks.size()));
    const double warmer_K = 0.5 * (before_degC + lab.tip_degC()) - experiment.heater.tip_degC;
    lab.wait(kRest_s);
    const double after_mg = lab.weigh_mg(o.material), volume = (after_mg - before_mg) / density;
    before_mg = after_mg;
    if (!(volume > 0.0))
      throw calibration::Unidentifiable(
          fmt::format("{} pulses at {:.0f} Hz have left nothing in the cup: does it stand under the nozzle, "
                      "is the tank empty?",
                      counted, hz));
    const double warmth = coil.fired(from_s, from_s + seconds, hz),
                 lag = slower.fired(from_s, from_s + seconds, hz) - warmth;
    weighings.push_back(
        {hz, volume, double(ticks.size()) / hz, gap_shares(ticks), warmth, lag, warmer_K, balance_mm3});
    if (o.progress) o.progress(double(weighings.size()) / double(order.size()));
  }
  const calibration::FlowCurveFit fit = calibration::calibrate_flow_curve(weighings);
  LabCalibration out;
  out.what = "flow-curve";
  FoundKey hz{section_of(o.material), "table_hz", "Hz", {}, {}, valve.table_hz, 4, true, 0.0},
      flow{section_of(o.material), "table_mm3_s", "mm^3/s", {}, {}, valve.table_mm3_s, 3, true, 0.0};
  for (const calibration::FlowCurveRow& r : fit.rows) {
    hz.value.push_back(r.frequency_hz);
    hz.ci95_half_width.push_back(0.0);
    flow.value.push_back(r.flow_mm3_s.value);
    flow.ci95_half_width.push_back(r.flow_mm3_s.ci95_half_width);
    if (r.flow_mm3_s.ci95_half_width > kFlowTolerance * r.flow_mm3_s.value)
      throw calibration::Unidentifiable(fmt::format(
          "the flow at {:.1f} Hz is known to +- {:.1f} % only; {:.0f} % is needed: weigh more (--repeats)",
          r.frequency_hz, 100.0 * r.flow_mm3_s.ci95_half_width / r.flow_mm3_s.value, 100.0 * kFlowTolerance));
  }
  out.keys = {hz, flow};
  out.lines.push_back(
      fmt::format("{} weighings of {} frequencies; the flow is that of the tip's set point and of a coil as "
                  "warm as {:.0f} pulses a second keep it",
                  weighings.size(), frequencies.size(), 1e3 * fit.warmth));
  out.also.emplace_back("pulses a second that keep the coil as warm [Hz]",
                        calibration::Estimate{1e3 * fit.warmth, 0.0, 0.0});
  out.data = fit.fit.data;
  out.outliers = fit.fit.outliers;
  out.residual_std = 100.0 * fit.fit.residual_std;
  out.residual_unit = "% of a drop";
  out.plot = {"frequency [Hz]", "mean drop off the curve [%]", {{"a weighing", {}, {}}}};
  for (std::size_t n = 0; n < weighings.size(); ++n) {
    out.plot.groups[0].x.push_back(weighings[n].frequency_hz);
    out.plot.groups[0].y.push_back(100.0 * fit.relative[n]);
  }
  out.lab_s = lab.now_s();
  return out;
}

}  // namespace firn
