// IceNature computes the joint state of arm, lines, bed and laser of the ice lab, in order of time. The
// instruments' twins pass on their commands; IceNature knows no protocol. A query changes nothing: results do
// not depend on the number of calls of catch_up().
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plant/ice/arm.h"
#include "plant/ice/bed.h"
#include "plant/ice/heat.h"
#include "plant/ice/line.h"
#include "plant/ice/point_laser.h"

namespace firn::plant {

/// Holds one list of pulses, from its trigger to its end.
struct Firing {
  bool active = false;
  std::uint32_t path = 0;
  double trigger_s = 0.0;  ///< world time of tick 0, the controller's own delay included
  double tick_s = 0.002;   ///< in world time
  double pulse_s = 0.00125;
  std::vector<std::uint16_t> ticks;
  std::uint64_t next = 0;  ///< pulses fired so far
  std::int64_t first_us = 0, last_us = 0;
  double volume_mm3 = 0.0;  ///< that left the nozzle
  double next_s() const { return trigger_s + double(ticks[next]) * tick_s; }
  void io(Archive& a) {
    a.all(active, path, trigger_s, tick_s, pulse_s, ticks, next, first_us, last_us, volume_mm3);
  }
};

/// Holds the laser controller's memory.
struct Storage {
  bool active = false;
  double trigger_s = 0.0, period_s = 0.01;
  std::uint32_t number = 0;  ///< storages begun before
  std::uint32_t most = 65536;
  LaserSettings settings = LaserSettings::kOther;
  std::vector<float> mm;  ///< NaN, +-infinity: no value, out of range
  double next_s() const { return trigger_s + double(mm.size()) * period_s; }
  void io(Archive& a) { a.all(active, trigger_s, period_s, number, most, settings, mm); }
};

struct Collisions {
  std::int64_t samples = 0;   ///< of the arm, 4 ms each, in which a nozzle was below the surface
  std::int64_t contacts = 0;  ///< times it began
  std::int64_t last_us = 0;
  double deepest_mm = 0.0, x_mm = 0.0, y_mm = 0.0;  ///< of the deepest
};

class IceNature {
 public:
  IceNature(const IceWorldConfig& config, std::uint64_t seed);

  /// Computes all events up to and including t_us.
  void catch_up(std::int64_t t_us);

  // Actions of instruments. @pre catch_up(the same time)
  void trigger_valve(int valve, double t_s, Firing list);
  /// @returns the list up to this pulse; it fires no more
  Firing close_valve(int valve);
  const Firing& firing(int valve) const { return firing_[std::size_t(valve)]; }
  void break_valve(int valve, bool broken) { broken_[std::size_t(valve)] = broken; }
  void jam_valve(int valve, bool jammed);  ///< it stays open from its next pulse on
  void begin_storage(double t_s, double period_s, std::uint32_t most, LaserSettings settings);
  void end_storage() { storage_.active = false; }
  const Storage& storage() const { return storage_; }
  double read_laser(std::int64_t t_us, LaserSettings settings);
  void darken_laser(bool dark) { dark_ = dark; }
  void stick_laser(bool stuck) { stuck_ = stuck; }  ///< every value repeats the one before

  TrueArm& arm() { return arm_; }
  Heat& heat() { return heat_; }
  Line& line(int valve) { return line_[std::size_t(valve)]; }
  const TrueArm& arm() const { return arm_; }
  const Heat& heat() const { return heat_; }
  const Bed& bed() const { return bed_; }
  Bed& bed() { return bed_; }
  const Collisions& collisions() const { return collisions_; }
  std::int64_t pulses(int valve) const { return line_[std::size_t(valve)].pulses(); }
  std::int64_t last_pulse_us(int valve) const { return last_pulse_us_[std::size_t(valve)]; }
  std::int64_t dead_pulses() const { return dead_; }  ///< without a drop: frozen, broken, beside the field
  void refresh() { renew_slow(); }                    ///< after a tank or a line was changed from outside
  double now_s() const { return now_s_; }
  void io(Archive& a);

 private:
  struct Jet {  ///< of one valve, between drops
    double x_mm = 0.0, y_mm = 0.0, t_s = -1e9, per_length_mm2 = 0.0;
    Wander wander_x, wander_y;
  };
  void pulse(int valve);
  void leak(int valve);  ///< of a valve that stays open
  /// @param draws of landing points, from the first of four numbers on; number of the pulse or the leak
  void land(int valve, double t_s, double volume_mm3, std::uint32_t draws, std::uint64_t number);
  void sample();
  double look(double t_s, LaserSettings settings, const LaserKey& key);
  void fall();
  double next_debris_s() const;
  void watch(double t_s, const ArmPose& pose);
  bool touch(double t_s, const ArmPose::Point& nozzle);
  ArmPose pose_at(double t_s);
  void renew_slow();

  IceWorldConfig config_;
  std::uint64_t seed_;
  TrueArm arm_;
  Heat heat_;
  std::array<Line, 2> line_;
  Bed bed_;
  std::array<Firing, 2> firing_;
  std::array<Jet, 2> jet_;
  Storage storage_;
  Collisions collisions_;
  std::array<bool, 2> broken_{}, jammed_{};
  std::array<double, 2> leak_s_{1e18, 1e18};  ///< when the next part of a leak has come out
  std::uint64_t leaks_ = 0;
  std::array<std::int64_t, 2> last_pulse_us_{-1, -1};
  std::int64_t dead_ = 0, readings_ = 0, slow_us_ = -1;
  std::uint32_t debris_ = 0;  ///< pieces fallen
  double debris_s_ = 0.0;     ///< when the last one fell
  double now_s_ = 0.0;
  double shown_mm_ = 0.0;  ///< the laser's newest value
  bool dark_ = false, stuck_ = false, touching_ = false;
};

}  // namespace firn::plant
