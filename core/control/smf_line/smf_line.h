// Computes the one-dimensional SMF loop of one point of the surface, its poles and its spread, over
// measurement intervals [Barnett 2012, 5.4 to 5.6]. All quantities are in units of the measurement interval
// dh_m, so gains are K_p, K_i*, K_d* of
// (5.2).
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace firn::control::smf_line {

struct Gains {
  double kp = 1.0, ki_star = 0.0, kd_star = 0.0;
  bool operator==(const Gains&) const = default;
};

/// d_k of (5.29) to (5.32) for intervals k = 1..intervals.
struct DisturbanceModel {
  int intervals = 100;
  double pulse = 0.0;   ///< d_p, at interval pulse_at only
  int pulse_at = 60;    ///< k_p, 1-based
  double step = 0.0;    ///< d_s, from interval step_at on
  int step_at = 30;     ///< k_s
  double random = 0.0;  ///< d_r: the amplitude of d_r (RN - 0.5), from interval random_at on
  int random_at = 1;    ///< k_r
  std::uint64_t seed = 1;
};

/// @throws std::invalid_argument: no interval, a number that is not finite
std::vector<double> disturbance(const DisturbanceModel& model);

/// e_1..e_n under d_1..d_n: e_1 = 0, u_k = K_p e_k + K_i* sum_{i<=k} e_i + K_d* (e_k - e_{k-1}) without the
/// last term at k = 1, and e_{k+1} = e_k - u_k - d_k. (5.11) with errata. `errors` and, if not empty,
/// `actions` (u_k) have d's length.
void simulate(const Gains& gains, std::span<const double> d, std::span<double> errors,
              std::span<double> actions = {});

/// sigma_p* of (5.27) and its gradient by K_p, K_i*, K_d* along the same simulation: (5.34) with (5.35) as
/// corrected.
struct Spread {
  double rms = 0.0;
  std::array<double, 3> gradient{};  ///< 0 where rms = 0
};
Spread spread(const Gains& gains, std::span<const double> d);

/// z^3 + c[2] z^2 + c[1] z + c[0], the denominator of (5.22).
std::array<double, 3> characteristic(const Gains& gains);

/// The poles of (5.22): largest modulus first.
std::array<std::complex<double>, 3> poles(const Gains& gains);
double largest_pole(const Gains& gains);  ///< z_p,max: modulus

/// All poles strictly inside the unit circle, by the Jury conditions: K_i* > 0, K_p/2 + K_i*/4 + K_d* < 1,
/// |K_d*| < 1, K_p + K_d* (K_p + K_i*) > 0, 2 - K_p - K_d* (K_p + K_i*) - 2 K_d*^2 > 0. Exact; (5.25) is only
/// sufficient (errata).
bool stable(const Gains& gains);
/// The smallest of those five margins: > 0 where stable.
double stability_margin(const Gains& gains);

/// d_k of a print from its errors and actions: d_k = e_k - u_k - e_{k+1} (5.17). One shorter than `errors`.
/// @throws std::invalid_argument: fewer than two errors, fewer actions than errors less one
std::vector<double> disturbance_of(std::span<const double> errors, std::span<const double> actions);

}  // namespace firn::control::smf_line
