// Heat computes the slow states of the end effector as one ODE (CVODE with root finding): temperatures of the
// three sections under three ON/OFF thermostats, flow gained by each valve's warm coil, volumes left in the
// tanks.
//
//   C_n T_n' = P_n relay_n + J f [n = a] - G_n (T_n - T_amb) - sum over neighbours L (T_n - T_m)
//   g_v'     = (coil_gain f_v / 500 Hz - g_v) / tau_v          flow factor 1 + g_v
//   tank_v'  = -Q_v
// f_v, Q_v: mean pulse rate and flow since the last step, constant within it. Roots are the thresholds of the
// thermostats (on below set - h, off above set + h) and the empty tanks; at each root the integrator stops,
// switches and restarts. A step is at most kStep_s long. A pulse reads the states at the step's beginning, so
// nothing is integrated per pulse (line.h computes the changes from pulse to pulse).
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "plant/config/ice_config.h"
#include "plant/record/archive.h"

namespace firn::plant {

struct HeatState {
  std::array<double, 3> section_degC{};
  std::array<double, 2> coil{};  ///< flow gained
  std::array<double, 2> tank_mm3{};
};

class Heat {
 public:
  static constexpr double kStep_s = 1.0;

  explicit Heat(const IceWorldConfig& config);
  ~Heat();
  Heat(Heat&&) noexcept;
  Heat& operator=(Heat&&) noexcept;

  /// Integrates up to `t_us`, with the pulses reported to fired() since the last call spread evenly over the
  /// time.
  /// @throws std::runtime_error naming the solver's call that failed
  void advance(std::int64_t t_us);
  /// Integrates only when a whole step is over: cheap enough for every pulse.
  void keep_up(std::int64_t t_us) {
    if (t_us - at_us_ >= std::int64_t(kStep_s * 1e6)) advance(t_us);
  }
  void fired(int valve, double volume_mm3) {
    ++pulses_[std::size_t(valve)];
    flown_mm3_[std::size_t(valve)] += volume_mm3;
  }

  const HeatState& state() const { return state_; }
  std::int64_t at_us() const { return at_us_; }
  bool relay(int n) const { return relay_[std::size_t(n)]; }
  double set_degC(int n) const { return set_degC_[std::size_t(n)]; }
  void set(int n, double degC);
  std::uint32_t switchings() const { return switchings_; }
  /// Returns the reading of thermocouple `n`; NaN when it is open.
  double shown_degC(int n) const;
  void break_heater(int n, bool broken) { broken_[std::size_t(n)] = broken; }
  void open_thermocouple(int n, bool open);
  void stick_relay(int n, bool stuck);
  void freeze_reading(
      int n, bool frozen);  ///< the thermocouple keeps its present reading, which also its thermostat uses
  void empty_tank(int valve) { state_.tank_mm3[std::size_t(valve)] = 0.0; }
  void fill_tank(int valve, double mm3) { state_.tank_mm3[std::size_t(valve)] = mm3; }
  void io(Archive& a);

 private:
  struct Solver;
  void step(double span_s);
  void obey_thermostats();

  IceHeatParams params_;
  std::array<double, 2> gain_per_hz_{}, tau_s_{};
  std::unique_ptr<Solver> solver_;
  HeatState state_;
  std::array<bool, 3> relay_{}, broken_{}, open_{}, stuck_{}, frozen_{};
  std::array<double, 3> frozen_degC_{};
  std::array<double, 3> set_degC_{};
  std::array<std::int64_t, 2> pulses_{};
  std::array<double, 2> flown_mm3_{};
  std::int64_t at_us_ = 0;
  std::uint32_t switchings_ = 0;
};

}  // namespace firn::plant
