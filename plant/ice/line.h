// Line computes the volume of one pulse of a micro-solenoid valve [mm^3], from tank to drop.
//
// Open valve: p = a Q^2 + b nu(T) Q, orifice of the nozzle (a = rho / (2 Cd^2 A^2)) and laminar loss before
// it; b follows from the stated full flow Q at the tank's pressure and 20 degC. nu(T) = nu_40 exp(B (1/T -
// 1/313.15 K)).
// Tubing: the line's pressure is p_tank (1 - s); s' = -s / tau + line_drop Q / (full flow tau), solved in
// closed form between pulses, so that at full flow s = line_drop.
// Valve: a pulse at `gap` after another opens it for t_pulse (1 - alpha exp(-gap / tau_r)).
// Volume = Q t_open (1 + coil) (1 + drift) (1 + pulsation). Low frequencies give Q(nu) = nu Q_0 t_pulse, high
// ones less [Barnett 2012, Fig. 6-1].
#pragma once

#include <cstdint>

#include "core/grid/random.h"
#include "plant/config/ice_config.h"
#include "plant/record/archive.h"

namespace firn::plant {

/// Returns the kinematic viscosity [mm^2/s].
double viscosity_mm2_s(const IceLineParams& p, double degC);
/// Returns the flow through the open valve [mm^3/s] at a pressure before it.
double open_flow_mm3_s(const IceLineParams& p, double pressure_kpa, double degC);

/// Samples an Ornstein-Uhlenbeck process of standard deviation 1 at any times.
struct Wander {
  double value = 0.0;
  std::int64_t draws = 0;
  /// @param draw a standard normal
  void step(double keep, double draw);
};

class Line {
 public:
  Line(const IceLineParams& params, std::uint64_t seed, int number);

  struct Slow {  ///< read from Heat at most once a second
    double degC = 20.0, coil = 0.0;
    bool empty = false;
  };
  void set_slow(const Slow& slow, double t_s);

  /// Returns the volume of the pulse that begins at t_s (which never decreases) and lasts pulse_s.
  double pulse(double t_s, double pulse_s);

  /// Returns the volume that a valve which does not close lets out from t_s on in open_s.
  double held_open(double t_s, double open_s);

  void count_open() { ++pulses_; }  ///< a pulse of a valve that does not close changes nothing

  void block(bool blocked) { blocked_ = blocked; }
  /// Returns the volume of a pulse amid many at a steady frequency, without the pulsation [mm^3]: closed
  /// form.
  double steady_pulse_mm3(double frequency_hz, double pulse_s) const;
  std::int64_t pulses() const { return pulses_; }
  double jet_speed_mm_s() const;

  void io(Archive& a) {
    a.all(params_, seed_, number_, orifice_, laminar_, factor_, sag_, last_s_, closed_s_);
    a.all(pulsation_, empty_, blocked_, pulses_);
  }

 private:
  double flow(double share) const;
  void settle(double t_s);  ///< the sag, since the last opening
  double sag_of(double volume_mm3) const;

  IceLineParams params_;
  std::uint64_t seed_ = 0;
  std::uint32_t number_ = 0;
  double orifice_ = 0.0, laminar_ = 0.0;  ///< p [kPa] = orifice_ Q^2 + laminar_ Q, Q in mm^3/s
  double factor_ = 1.0;                   ///< coil and drift
  double sag_ = 0.0, last_s_ = -1e9, closed_s_ = -1e9;
  Wander pulsation_;
  bool empty_ = false, blocked_ = false;
  std::int64_t pulses_ = 0;
};

}  // namespace firn::plant
