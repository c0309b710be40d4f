// SecondOrder computes samples of x'' + 2 zeta w x' + w^2 x = w^2 u + b u' exactly for an input that is
// straight between samples: the servo of a joint (b = 0) and a mass on a moving, damped spring (b = 2 zeta
// w).
#pragma once

#include <array>

namespace firn::plant {

class SecondOrder {
 public:
  /// @param rate_input true: u' acts too (through the damper)
  SecondOrder(double hz, double damping, bool rate_input, double step_s);

  struct State {
    double x = 0.0, q = 0.0;  ///< q = x' - b u
  };
  /// At rest on u.
  State at_rest(double u) const { return {u, -b_ * u}; }
  /// Computes one step with the input going from u0 to u1.
  State next(const State& s, double u0, double u1) const {
    return {a_[0] * s.x + a_[1] * s.q + b0_[0] * u0 + b1_[0] * u1,
            a_[2] * s.x + a_[3] * s.q + b0_[1] * u0 + b1_[1] * u1};
  }
  double velocity(const State& s, double u) const { return s.q + b_ * u; }

 private:
  double b_ = 0.0;
  std::array<double, 4> a_{};
  std::array<double, 2> b0_{}, b1_{};
};

}  // namespace firn::plant
