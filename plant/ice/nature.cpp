#include "plant/ice/nature.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

constexpr double kNever_s = 1e18;
// A drop further from the last one than this, in place or time, begins a new bead.
constexpr double kBeadBreak_mm = 4.0, kBeadBreak_s = 0.25;
constexpr double kSmoothing = 0.3;  ///< of the volume per length: the list's raster makes spacings jump
constexpr double kNoPoint_mm = 1e-3;
constexpr double kLeak_s = 0.004;  // of a valve that stays open: the volume of so much time is one drop

double seconds(std::int64_t us) { return double(us) * 1e-6; }

}  // namespace

IceNature::IceNature(const IceWorldConfig& config, std::uint64_t seed)
    : config_(config),
      seed_(seed),
      arm_(config.arm),
      heat_(config),
      line_{Line(config.line[0], seed, 0), Line(config.line[1], seed, 1)},
      bed_(config, seed) {
  renew_slow();
}

ArmPose IceNature::pose_at(double t_s) {
  return arm_.at(t_s, [this](double at_s, const ArmPose& pose) { watch(at_s, pose); });
}

void IceNature::catch_up(std::int64_t t_us) {
  const double t_s = seconds(t_us);
  for (;;) {
    const double a_s = firing_[0].active ? firing_[0].next_s() : kNever_s;
    const double b_s = firing_[1].active ? firing_[1].next_s() : kNever_s;
    const double laser_s = storage_.active ? storage_.next_s() : kNever_s, debris_s = next_debris_s();
    const double leak_s = std::min(leak_s_[0], leak_s_[1]);
    const double first_s = std::min({a_s, b_s, laser_s, debris_s, leak_s});
    if (first_s > t_s) break;
    now_s_ = std::max(now_s_, first_s);
    if (first_s == debris_s)
      fall();
    else if (first_s == laser_s)
      sample();
    else if (first_s == leak_s)
      leak(first_s == leak_s_[0] ? 0 : 1);
    else
      pulse(first_s == a_s ? 0 : 1);
  }
  arm_.run_until(t_s, [this](double at_s, const ArmPose& pose) { watch(at_s, pose); });
  now_s_ = std::max(now_s_, t_s);
}

void IceNature::renew_slow() {
  slow_us_ = heat_.at_us();
  const HeatState& s = heat_.state();
  for (std::size_t v = 0; v < 2; ++v)
    line_[v].set_slow({s.section_degC[0], s.coil[v], s.tank_mm3[v] <= 0.0}, seconds(slow_us_));
}

void IceNature::pulse(int valve) {
  const auto v = std::size_t(valve);
  Firing& list = firing_[v];
  const double t_s = list.next_s();
  const auto t_us = std::int64_t(std::llround(t_s * 1e6));
  heat_.keep_up(t_us);
  if (heat_.at_us() != slow_us_) renew_slow();

  if (list.next == 0) list.first_us = t_us;
  list.last_us = last_pulse_us_[v] = t_us;
  if (++list.next == list.ticks.size()) list.active = false;
  if (leak_s_[v] < kNever_s) return line_[v].count_open();
  if (jammed_[v]) leak_s_[v] = t_s + kLeak_s;

  double volume_mm3 = line_[v].pulse(t_s, list.pulse_s);
  const double freeze_degC = valve == 0 ? config_.heat.freeze_degC : config_.heat.freeze_sme_degC;
  if (broken_[v] || heat_.state().section_degC[0] < freeze_degC) volume_mm3 = 0.0;
  heat_.fired(valve, volume_mm3);
  if (volume_mm3 <= 1e-9) {
    ++dead_;
    return;
  }
  list.volume_mm3 += volume_mm3;
  land(valve, t_s, volume_mm3, 0, std::uint64_t(line_[v].pulses()));
}

void IceNature::jam_valve(int valve, bool jammed) {
  jammed_[std::size_t(valve)] = jammed;
  if (!jammed) leak_s_[std::size_t(valve)] = kNever_s;
}

void IceNature::leak(int valve) {
  const auto v = std::size_t(valve);
  const double t_s = leak_s_[v];
  leak_s_[v] += kLeak_s;
  const auto t_us = std::int64_t(std::llround(t_s * 1e6));
  heat_.keep_up(t_us);
  if (heat_.at_us() != slow_us_) renew_slow();
  const double volume_mm3 = line_[v].held_open(t_s - kLeak_s, kLeak_s);
  heat_.fired(valve, volume_mm3);
  if (volume_mm3 > 1e-9) land(valve, t_s, volume_mm3, 4, ++leaks_);
}

void IceNature::land(int valve, double t_s, double volume_mm3, std::uint32_t draws, std::uint64_t number) {
  const auto v = std::size_t(valve);
  const IceBeadParams& bead = config_.bead[v];
  const double leaves_s = t_s + config_.line[v].open_delay_s;
  const ArmPose pose = pose_at(leaves_s);
  const ArmPose::Point nozzle = pose.tool(valve == 0 ? config_.arm.valve_a : config_.arm.valve_b);
  bed_.set_nozzle_height(nozzle.z_mm);
  const double gap_mm = std::clamp(nozzle.z_mm - bed_.height_mm(nozzle.x_mm, nozzle.y_mm), 0.1, 60.0);

  Jet& jet = jet_[v];
  const double since_s = leaves_s - jet.t_s, dx = nozzle.x_mm - jet.x_mm, dy = nozzle.y_mm - jet.y_mm;
  const double spacing_mm = std::sqrt(dx * dx + dy * dy);
  if (since_s > kBeadBreak_s || spacing_mm > kBeadBreak_mm) {
    jet.per_length_mm2 = 0.0;
  } else {
    const double now_mm2 = volume_mm3 / std::max(spacing_mm, 0.05);
    jet.per_length_mm2 = jet.per_length_mm2 == 0.0
                             ? now_mm2
                             : jet.per_length_mm2 + kSmoothing * (now_mm2 - jet.per_length_mm2);
  }
  jet.x_mm = nozzle.x_mm;
  jet.y_mm = nozzle.y_mm;
  jet.t_s = leaves_s;
  const auto draw = [&](std::uint32_t which) {
    return random_normal({seed_, Purpose::kDropletPlacement, 10 * std::uint32_t(valve) + draws + which,
                          std::uint32_t(number >> 32), std::uint32_t(number)});
  };
  const double keep = std::exp(-std::max(0.0, since_s) / bead.wander_tau_s);
  jet.wander_x.step(keep, draw(0));
  jet.wander_y.step(keep, draw(1));
  const double scatter_mm = bead.scatter_mm * gap_mm / config_.disturbance.gap_mm,
               lean_mm = bead.wander_rad * gap_mm;
  const double flight_s = gap_mm / line_[v].jet_speed_mm_s();
  bed_.land({nozzle.x_mm + pose.vx_mm_s * flight_s + scatter_mm * draw(2) + lean_mm * jet.wander_x.value,
             nozzle.y_mm + pose.vy_mm_s * flight_s + scatter_mm * draw(3) + lean_mm * jet.wander_y.value,
             volume_mm3, jet.per_length_mm2, valve});
}

void IceNature::trigger_valve(int valve, double t_s, Firing list) {
  Firing& mine = firing_[std::size_t(valve)];
  mine = std::move(list);
  mine.trigger_s = t_s;
  mine.next = 0;
  mine.volume_mm3 = 0.0;
  mine.active = !mine.ticks.empty();
}

Firing IceNature::close_valve(int valve) {
  Firing& mine = firing_[std::size_t(valve)];
  mine.active = false;
  return mine;
}

void IceNature::begin_storage(double t_s, double period_s, std::uint32_t most, LaserSettings settings) {
  const std::uint32_t number = storage_.number + 1;
  storage_ = {true, t_s, period_s, number, most, settings, {}};
}

double IceNature::look(double t_s, LaserSettings settings, const LaserKey& key) {
  if (dark_) return std::numeric_limits<double>::quiet_NaN();
  if (!stuck_)
    shown_mm_ = laser_reading_mm(config_.laser, bed_, config_.arm.laser, pose_at(t_s), settings, key);
  return shown_mm_;
}

void IceNature::sample() {
  const auto n = std::uint32_t(storage_.mm.size());
  storage_.mm.push_back(float(look(storage_.next_s(), storage_.settings, {seed_, storage_.number, n})));
  if (storage_.mm.size() >= storage_.most) storage_.active = false;
}

double IceNature::read_laser(std::int64_t t_us, LaserSettings settings) {
  return look(seconds(t_us), settings, {seed_, 0, std::uint32_t(++readings_)});
}

double IceNature::next_debris_s() const {
  const double rate_s = config_.disturbance.debris_per_h / 3600.0;
  if (rate_s <= 0.0) return kNever_s;
  return debris_s_ - std::log(1.0 - random_uniform({seed_, Purpose::kDisturbance, 1, 0, debris_})) / rate_s;
}

void IceNature::fall() {
  debris_s_ = next_debris_s();
  const auto draw = [&](std::uint32_t which) {
    return random_uniform({seed_, Purpose::kDisturbance, 2, which, debris_});
  };
  const IceDisturbanceParams& d = config_.disturbance;
  const double x = config_.field.x0_mm + config_.field.width_mm * draw(0);
  const double y = config_.field.y0_mm + config_.field.height_mm * draw(1);
  if (bed_.ground(x, y) != Ground::kTable)
    bed_.add_debris(x, y, d.debris_height_mm * (0.2 + 0.8 * draw(2)), d.debris_radius_mm * (0.5 + draw(3)));
  ++debris_;
}

// Nozzles are the lowest points of the end effector.
void IceNature::watch(double t_s, const ArmPose& pose) {
  const bool a = touch(t_s, pose.tool(config_.arm.valve_a)), b = touch(t_s, pose.tool(config_.arm.valve_b));
  if ((a || b) && !touching_) ++collisions_.contacts;
  touching_ = a || b;
  collisions_.samples += touching_;
}

bool IceNature::touch(double t_s, const ArmPose::Point& nozzle) {
  const double highest_mm = config_.table.jigs.empty() ? bed_.highest_mm() : kNever_s;
  if (nozzle.z_mm >= highest_mm) return false;
  const double deep_mm = bed_.height_mm(nozzle.x_mm, nozzle.y_mm) - nozzle.z_mm;
  if (deep_mm < kNoPoint_mm) return false;
  collisions_.last_us = std::int64_t(std::llround(t_s * 1e6));
  if (deep_mm > collisions_.deepest_mm) {
    collisions_.deepest_mm = deep_mm;
    collisions_.x_mm = nozzle.x_mm;
    collisions_.y_mm = nozzle.y_mm;
  }
  return true;
}

void IceNature::io(Archive& a) {
  a.all(arm_, heat_, line_[0], line_[1], bed_, firing_[0], firing_[1], jet_[0], jet_[1], storage_,
        collisions_, broken_, jammed_, leak_s_, leaks_, last_pulse_us_, dead_, readings_, slow_us_, debris_,
        debris_s_, now_s_, shown_mm_, dark_, stuck_, touching_);
}

}  // namespace firn::plant
