// Computes the waveform of a jet from strobe sweeps: the dwell time of the fastest droplets, and the voltage
// of a wanted velocity.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "drivers/jet/jet_driver.h"
#include "estimators/calibration/jet_waveform.h"
#include "files/usage_error.h"
#include "firn/camera_command_t.hpp"
#include "firn/droplet_sweep_t.hpp"
#include "firn/enums.h"
#include "firn/jet_command_t.hpp"
#include "firn/service_order_t.hpp"
#include "firn/stage_command_t.hpp"
#include "procs/camera/node.h"
#include "procs/droplet_watch/node.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/safety/node.h"
#include "procs/stage/node.h"
#include "studies/calibrate/commanded_lab.h"
#include "studies/calibrate/jet_picture.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn {
namespace {

using calibration::JetSpeed;

constexpr double kReadySweep_s = 120.0, kAnswerSweep_s = 30.0, kPicture_s = 3.0, kResult_s = 30.0;
constexpr double kDwellTolerance_us = 1.0, kVoltTolerance_v = 1.0;
constexpr double kMinDwell = 0.4, kMaxDwell = 2.0;  // of the lab's, first round
constexpr int kDwells = 13, kFineDwells = 9;
constexpr double kFineShare = 0.3;                  // of the best dwell time, either side, second round
constexpr double kMinVolts = 0.6, kMaxVolts = 1.6;  // of the lab's
constexpr int kVoltages = 11;
constexpr std::size_t kMinGivenDwells = 3;  // the fastest lies between others
constexpr double kTenth_us = 0.1;

constexpr std::pair<NodeId, MakeNode> kJetNodes[] = {{NodeId::kStage, &make_stage},
                                                     {NodeId::kJet, &make_jet},
                                                     {NodeId::kJetB, &make_jet_b},
                                                     {NodeId::kLaserProfiler, &make_laser_profiler},
                                                     {NodeId::kLamp, &make_lamp},
                                                     {NodeId::kCamera, &make_camera},
                                                     {NodeId::kDropletWatch, &make_droplet_watch},
                                                     {NodeId::kSafety, &make_safety}};

std::vector<std::pair<NodeId, MakeNode>> nodes_of(const Experiment& e) {
  std::vector<std::pair<NodeId, MakeNode>> nodes;
  for (const auto& node : kJetNodes)
    if (takes_part(e, info(node.first).name)) nodes.push_back(node);
  return nodes;
}

/// Holds the first pulse of a waveform; the second keeps its ratio to it, if the jet has one.
struct Pulse {
  double dwell_us = 0.0, volts = 0.0;
};

double echo_us_of(const JetConfig& jet, const Pulse& p) {
  if (!drivers::traits_of(jet.kind).second_pulse) return 0.0;
  return std::round(p.dwell_us * jet.echo_us / jet.dwell_us / kTenth_us) * kTenth_us;
}
double echo_v_of(const JetConfig& jet, const Pulse& p) {
  return drivers::traits_of(jet.kind).second_pulse ? std::round(p.volts * jet.echo_v / jet.dwell_v) : 0.0;
}

class JetLab final : public CommandedLab {
 public:
  explicit JetLab(const Experiment& e) : CommandedLab(e, nodes_of(e), {}), experiment_(e) {}

  double echo_us(const Pulse& p) const { return echo_us_of(experiment_.jet, p); }
  double echo_v(const Pulse& p) const { return echo_v_of(experiment_.jet, p); }

  void get_ready() {
    get_safe(kReadySweep_s);
    stage_command_t c{};
    c.verb = std::int8_t(StageVerb::kHome);
    command(channels::kStageCommand, c, kReadySweep_s, "homing");
    c.verb = std::int8_t(StageVerb::kMove);
    c.x_mm = experiment_.watch.x_mm;
    c.y_mm = experiment_.watch.y_mm;
    c.z_mm = experiment_.process.nozzle_gap_mm;
    c.speed_mm_s = experiment_.process.pass_speed_mm_s;
    command(channels::kStageCommand, c, kAnswerSweep_s, "moving to the camera");
  }

  /// One sweep of strobe pictures with this waveform.
  droplet_sweep_t watch(const Pulse& p) {
    service_order_t order{};
    order.node = info(NodeId::kJet).name;
    order.verb = "waveform";
    order.values = {p.volts, echo_v(p), p.dwell_us, echo_us(p)};
    order.n = std::int32_t(order.values.size());
    const std::string what = fmt::format("a pulse of {:g} V for {:g} us", p.volts, p.dwell_us);
    command(channels::kServiceOrder, order, kAnswerSweep_s, what, NodeId::kLauncher);
    jet_command_t jet{};
    jet.verb = std::int8_t(JetVerb::kJet);
    command(channels::kJetCommand, jet, kAnswerSweep_s, what + ": jetting");
    const droplet::WatchOptions& o = experiment_.watch;
    camera_command_t c{};
    c.verb = std::int8_t(CameraVerb::kSweep);
    c.sweep_id = ++sweeps_;
    c.frames = o.frames;
    c.delay_us = o.first_us;
    c.step_us = o.step_us;
    c.gain_db = experiment_.camera.gain_db;
    sweep_.reset();
    command(channels::kCameraCommand, c, kAnswerSweep_s + kPicture_s * o.frames, what + ": pictures");
    jet.verb = std::int8_t(JetVerb::kDisarm);
    command(channels::kJetCommand, jet, kAnswerSweep_s, what + ": ending the jetting");
    until([&] { return sweep_.has_value(); }, kResult_s, what + ": the droplets' measurement");
    return *sweep_;
  }
  std::int64_t sweeps() const { return sweeps_; }

 private:
  void heard(std::string_view channel, std::span<const std::byte> bytes) override {
    if (channel != channels::kDropletSweep.name) return;
    if (auto m = decoded<droplet_sweep_t>(bytes); m && m->sweep_id == sweeps_) sweep_ = std::move(m);
  }

  Experiment experiment_;
  std::int64_t sweeps_ = 0;
  std::optional<droplet_sweep_t> sweep_;
};

/// Sweeps over waveforms, and what they say.
struct Round {
  JetLab& lab;
  const Experiment& e;
  const LabCalibrationOptions& o;
  double sweeps_in_all = 1.0;
  int with_satellites = 0;

  std::vector<JetSpeed> over(const std::vector<Pulse>& pulses) {
    std::vector<JetSpeed> seen;
    for (int n = 0; n < std::max(1, o.repeats); ++n)
      for (const Pulse& p : pulses) {
        const droplet_sweep_t m = lab.watch(p);
        if (m.with_droplet > 0 && m.um_per_px == 0.0)
          throw std::invalid_argument("the pictures have no scale: set watch.um_per_px or watch.nozzle_um");
        if (m.known & std::int32_t(SweepValue::kVelocity))
          seen.push_back({p.dwell_us, p.volts, 1e-3 * m.velocity_mm_s, 1e-3 * m.velocity_std_mm_s});
        with_satellites += m.satellites > e.watch.satellites_most;
        if (o.progress) o.progress(std::min(1.0, double(lab.sweeps()) / sweeps_in_all));
      }
    return seen;
  }
};

double in_steps(double value, double step) { return std::round(value / step) * step; }

std::vector<Pulse> dwells(double low_us, double high_us, int count, double volts, double step_us) {
  std::vector<Pulse> pulses;
  for (int k = 0; k < count; ++k)
    pulses.push_back({in_steps(low_us + (high_us - low_us) * k / (count - 1), step_us), volts});
  return pulses;
}

std::vector<Pulse> voltages(const Experiment& e, const LabCalibrationOptions& o, double dwell_us) {
  const double most = e.jet.dialect.max_abs_v / std::max(1.0, std::abs(e.jet.echo_v / e.jet.dwell_v));
  std::set<double> volts;
  for (int k = 0; k < kVoltages; ++k)
    volts.insert(std::round(e.jet.dwell_v * (kMinVolts + (kMaxVolts - kMinVolts) * k / (kVoltages - 1))));
  if (!o.voltages_v.empty()) volts = {o.voltages_v.begin(), o.voltages_v.end()};
  std::vector<Pulse> pulses;
  for (const double v : volts)
    if (std::abs(v) <= most && v != 0.0) pulses.push_back({dwell_us, v});
  return pulses;
}

std::vector<Pulse> first_dwells(const Experiment& e, const LabCalibrationOptions& o, double step_us) {
  if (o.dwells_us.empty())
    return dwells(kMinDwell * e.jet.dwell_us, kMaxDwell * e.jet.dwell_us, kDwells, e.jet.dwell_v, step_us);
  std::vector<Pulse> pulses;
  for (const double d : o.dwells_us) pulses.push_back({d, e.jet.dwell_v});
  std::ranges::sort(pulses, {}, &Pulse::dwell_us);
  return pulses;
}

void check_count(const char* option, const char* what, const std::vector<double>& given, std::size_t least) {
  const std::size_t count = std::set<double>(given.begin(), given.end()).size();
  if (!given.empty() && count < least)
    throw UsageError(fmt::format("{}: {} different {}, {} at least are needed", option, count, what, least));
}

void check_pulse(const char* option, double value, const JetConfig& jet, const Pulse& p) {
  const std::string why =
      drivers::refusal_of({p.volts, echo_v_of(jet, p), p.dwell_us, echo_us_of(jet, p)}, jet);
  if (!why.empty()) throw UsageError(fmt::format("{} {:g}: {}", option, value, why));
}

/// Checks the dwell times and voltages of the user. The jet itself would refuse them when their turn comes.
/// @throws UsageError naming option, value and limit
void check_given(const JetConfig& jet, const LabCalibrationOptions& o, double step_us) {
  check_count("--dwells", "dwell times", o.dwells_us, kMinGivenDwells);
  check_count("--voltages", "voltages", o.voltages_v, calibration::kMinVoltages);
  for (const double d : o.dwells_us) {
    if (std::abs(d - in_steps(d, step_us)) > 1e-6)
      throw UsageError(fmt::format("--dwells {:g}: the jet takes multiples of {:g} us", d, step_us));
    check_pulse("--dwells", d, jet, {d, jet.dwell_v});
  }
  for (const double v : o.voltages_v) {
    if (v == 0.0) throw UsageError("--voltages 0: a pulse of 0 V drives no droplet");
    check_pulse("--voltages", v, jet, {jet.dwell_us, v});
  }
}

/// @throws Unidentifiable: no maximum within the range
double coarse_best(const std::vector<JetSpeed>& seen, const std::vector<Pulse>& tried) {
  if (seen.empty())
    throw calibration::Unidentifiable(fmt::format(
        "no droplet was measured at any dwell time from {:g} to {:g} us: a dead nozzle, or too low a voltage",
        tried.front().dwell_us, tried.back().dwell_us));
  const double best = calibration::fastest(seen).dwell_us;
  if (best <= tried.front().dwell_us || best >= tried.back().dwell_us)
    throw calibration::Unidentifiable(
        fmt::format("the velocity is largest at {:g} us, an end of the range of dwell times: give others "
                    "with --dwells",
                    best));
  return best;
}

}  // namespace

LabCalibration calibrate_jet(const Experiment& given, const LabCalibrationOptions& o) {
  using namespace lab_calibrations;
  Experiment e = given;
  if (!takes_part(e, "jet"))
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": this lab has no jet");
  if (e.jet.dwell_v == 0.0) throw std::invalid_argument("jet.dwell_v = 0: the waveform has no first pulse");
  e.camera.use = OnOff::kOn;
  const double wanted =
      o.velocity_m_s > 0.0 ? o.velocity_m_s : 0.5 * (e.watch.velocity_least_m_s + e.watch.velocity_most_m_s);
  const double step_us = drivers::traits_of(e.jet.kind).step_us;

  check_given(e.jet, o, step_us);
  JetLab lab(e);
  lab.get_ready();
  const std::vector<Pulse> first = first_dwells(e, o, step_us);
  Round round{lab, e, o,
              std::max(1, o.repeats) * double(first.size() + kFineDwells + voltages(e, o, 1.0).size())};
  std::vector<JetSpeed> coarse = round.over(first);
  const double best = coarse_best(coarse, first);
  const std::vector<JetSpeed> fine = round.over(
      dwells((1.0 - kFineShare) * best, (1.0 + kFineShare) * best, kFineDwells, e.jet.dwell_v, step_us));
  std::vector<JetSpeed> near = fine;
  for (const JetSpeed& s : coarse)
    if (std::abs(s.dwell_us - best) <= kFineShare * best) near.push_back(s);
  const calibration::BestDwell dwell = calibration::fit_best_dwell(near);
  const double chosen_us = in_steps(dwell.dwell_us.value, step_us);

  const std::vector<Pulse> tried = voltages(e, o, chosen_us);
  const std::vector<JetSpeed> rising = round.over(tried);
  const calibration::VoltageLine line = calibration::fit_voltage(rising, wanted);
  const double lowest = tried.front().volts, highest = tried.back().volts;
  if (line.volts.value < std::min(lowest, highest) - 1.0 ||
      line.volts.value > std::max(lowest, highest) + 1.0)
    throw calibration::Unidentifiable(fmt::format(
        "{:g} m/s need about {:.0f} V, and the voltages tried end at {:g} and {:g} V: give others "
        "with --voltages, or another --velocity",
        wanted, line.volts.value, lowest, highest));

  LabCalibration out;
  out.what = "jet";
  const Pulse found{chosen_us, std::round(line.volts.value)};
  const double ratio_us = lab.echo_us(found) / found.dwell_us,
               ratio_v = std::abs(lab.echo_v(found) / found.volts);
  out.keys = {{"jet",
               "dwell_us",
               "us",
               {found.dwell_us},
               {dwell.dwell_us.ci95_half_width},
               {e.jet.dwell_us},
               2,
               false,
               kDwellTolerance_us},
              {"jet",
               "dwell_v",
               "V",
               {found.volts},
               {line.volts.ci95_half_width},
               {e.jet.dwell_v},
               2,
               false,
               kVoltTolerance_v}};
  if (ratio_us > 0.0) {
    out.keys.push_back({"jet",
                        "echo_us",
                        "us",
                        {lab.echo_us(found)},
                        {ratio_us * dwell.dwell_us.ci95_half_width},
                        {e.jet.echo_us},
                        2,
                        false,
                        0.0});
    out.keys.push_back({"jet",
                        "echo_v",
                        "V",
                        {lab.echo_v(found)},
                        {ratio_v * line.volts.ci95_half_width},
                        {e.jet.echo_v},
                        2,
                        false,
                        0.0});
  }
  out.also.emplace_back(fmt::format("velocity at {:g} V and the best dwell time [m/s]", e.jet.dwell_v),
                        dwell.velocity_m_s);
  out.also.emplace_back("threshold [V]", line.threshold_v);
  out.also.emplace_back("velocity per volt [m/s]", line.slope_m_s_v);
  out.also.emplace_back(fmt::format("voltage for {:g} m/s [V]", wanted), line.volts);
  out.lines.push_back(
      fmt::format("{} sweeps of {} strobe pictures; proposed: the dwell time of the fastest droplets, and "
                  "the whole volts "
                  "nearest to {:g} m/s",
                  lab.sweeps(), e.watch.frames, wanted));
  if (round.with_satellites > 0)
    out.lines.push_back(fmt::format("{} of the sweeps show more satellites than watch.satellites_most = {:g}",
                                    round.with_satellites, e.watch.satellites_most));
  out.data = dwell.fit.data + line.fit.data;
  out.outliers = dwell.fit.outliers + line.fit.outliers;
  out.residual_std = dwell.fit.residual_std;
  out.residual_unit = "of the velocity's standard deviation";
  coarse.insert(coarse.end(), fine.begin(), fine.end());
  out.picture = jet_picture({coarse, rising, dwell, line, wanted, found.dwell_us, found.volts});
  out.lab_s = lab.now_s();
  check_intervals(out);
  return out;
}

}  // namespace firn
