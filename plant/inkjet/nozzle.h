// Nozzle computes the slow states of ink line and nozzle, which make droplets drift in size, integrated by
// SUNDIALS' CVODE.
#pragma once

#include <cstdint>
#include <memory>

#include "plant/config/world_config.h"
#include "plant/record/archive.h"

namespace firn::plant {

/// States: p line pressure (relative deviation), w wetting of the nozzle plate (0..1), T heating [K],
/// d wander. With f = droplets per second, held constant over a step:
///   dp/dt = -p / tau_p - k_p f        dw/dt = k_w f (1 - w) - w / tau_w
///   dT/dt = k_T f - T / tau_T         dd/dt = (D_k - d) / tau_d
/// D_k after the first cure of layer k: D_0 = 0, D_k = m D_{k-1} + sqrt(1 - m^2) sigma n_k, n_k ~ N(0,1)
/// keyed by k and the nozzle. Volume of a droplet = nominal x (1 + p + c_w w + c_T T + d).
struct NozzleState {
  double pressure = 0.0, wetting = 0.0, heating_K = 0.0, wander = 0.0;
};

class Nozzle {
 public:
  /// @param number of the nozzle, from 0: each nozzle's wander has its own draws
  Nozzle(const NozzleParams& params, std::uint64_t seed, std::uint32_t number = 0);
  ~Nozzle();
  Nozzle(Nozzle&&) noexcept;
  Nozzle& operator=(Nozzle&&) noexcept;

  /// Fires one droplet at `now_us` and returns the volume factor. The ODE is advanced only when step_s has
  /// passed.
  double fire(std::int64_t now_us);
  /// Advances to `now_us`, when layer `layer` (1-based) is first cured, and draws the wander's next target.
  void cured(std::int64_t now_us, std::uint32_t layer);
  const NozzleState& state() const { return state_; }
  void io(Archive& a) { a.all(state_, at_us_, drops_, target_, factor_); }

 private:
  void advance(std::int64_t now_us);

  NozzleParams params_;
  std::uint64_t seed_;
  std::uint32_t number_;
  NozzleState state_;
  std::int64_t at_us_ = 0;  ///< time of state_
  std::int64_t drops_ = 0;  ///< since then
  double target_ = 0.0;
  double factor_ = 1.0;
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace firn::plant
