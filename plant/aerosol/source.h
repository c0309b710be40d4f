// Source computes what an aerosol nozzle gives off: atomizer and tube, clogging, shutter with delays and
// tails, and the blob that gathers at a closed shutter.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>

#include "plant/record/archive.h"

namespace firn::plant {

/// Numbers without a source are our own: docs/aerosol.md.
struct AerosolParams {
  double flow_mm3_s = 0.005;  ///< nominal flow of ink [the machine's]
  double solids = 0.2;        ///< share of the ink that stays
  double flow = 1.0, drift = 0.0, drift_s = 300.0, wander = 0.01;
  double tube_s = 2.0;     ///< time constant of mixing between atomizer and nozzle
  double wander_s = 20.0;  ///< between two draws of the output's random part
  double clog_per_h = 0.02;
  double vial_s = 36'000.0;  ///< in which the nominal flow empties the full vial
  double level_loss = 0.0;   ///< of the output, from the full to the empty vial
  double tube_per_h = 0.0;   ///< growth of the share of mist that settles in the tube
  double open_delay_s = 0.03, close_delay_s = 0.045, tail_s = 0.006;
  double blob_s = 0.02;     ///< most that gathers, in seconds of nominal flow
  double gather_s = 1.0;    ///< time constant of gathering
  double release_s = 0.01;  ///< and of the release after opening
  double nozzle_mm = 0.28, focusing_ratio = 2.0;
  double spread = 0.05;  ///< growth of sigma^2 per wet cross-section
  double overspray = 0.05, halo = 4.0;
  double optical_depth_mm = 0.002;               ///< of dry ink, as the camera sees it
  double camera_x_mm = 30.0, camera_y_mm = 0.0;  ///< true place of the camera's middle, from the nozzle
  double camera_turn = 0.0;                      ///< about its axis [rad]
  bool gas = false;  ///< the atomizer's gas comes from a controller: none flows at first
  bool operator==(const AerosolParams&) const = default;
};

/// The gas of a moment: the atomizer's by that at which the flow is nominal, the sheath's by the atomizer's,
/// and the share of the nozzle's section that is open beside the part that ink has closed.
struct GasSupply {
  double atomizer = 1.0, focusing_ratio = 2.0, open_share = 1.0;
};

/// Standard deviation of the beam where it lands. A laminar flow through the nozzle of diameter D whose
/// middle is aerosol and whose rest is sheath gas, R times as much: within the share s of the radius flows 1
/// - (1 - s^2)^2 of the whole (Poiseuille), which is 1 / (1 + R), so s^2 = 1 - sqrt(R / (1 + R)). The line is
/// s D wide, taken as four sigma.
double beam_sigma_mm(double nozzle_mm, double focusing_ratio);
inline double beam_sigma_mm(const AerosolParams& p) { return beam_sigma_mm(p.nozzle_mm, p.focusing_ratio); }

/// Ink [mm^3] that flowed in a step: what passed the shutter, and what it kept.
struct Given {
  double passed_mm3 = 0.0, kept_mm3 = 0.0;
};

/// States, integrated by SUNDIALS' CVODE:
///   dm/dt = (q a(t) - m) / tube_s             a: the atomizer's output, 1 + drift t / drift_s + wander, t
///   since
///                                             it began; q: its gas, which carries as much mist a volume
///   dc/dt = k_c m (1 - s) (1 - c)             c: share of the nozzle's section that is closed
///   dl/dt = -flow m / vial_s                  l: the vial's level, 1 = full; a is (1 - loss (1 - l)) times
///   as much ds/dt = k_t m (1 - s)                     s: share of the mist that settles in the tube
/// The flow is nominal x flow x m (1 - s) (1 - c) x the open share of the supply. Level and tube are among
/// the hidden states of Agarwal et al. (arXiv 2511.00593, abstract read), which drift in the prints of Salary
/// et al. (J. Micro Nano-Manuf. 2021, abstract read); the equations and the values are ours. Off, l = 1 and s
/// = 0. The shutter's opening f follows its
/// switch after a delay: df/dt = (target - f) / tail_s. Ink that gathers: db/dt = (b_max - b) / gather_s
/// while closed, -b / release_s while open; both are exact over a step.
class Source {
 public:
  Source(const AerosolParams& params, std::uint64_t seed);
  ~Source();
  Source(Source&&) noexcept;
  Source& operator=(Source&&) noexcept;

  void switch_shutter(bool open, std::int64_t t_us);
  void supply(const GasSupply& gas);  ///< from the last step's end on
  bool commanded_open() const { return commanded_; }
  double opening() const { return opening_; }
  /// A step from the last one's end to t_us. @pre not across next_change_us()
  Given step(std::int64_t t_us);
  std::int64_t at_us() const { return at_us_; }
  /// The next time at which the shutter begins to move; INT64_MAX: none.
  std::int64_t next_change_us() const;
  bool quiet() const { return opening_ < 1e-6 && !target_; }  ///< nothing passes until the next change
  double flow_mm3_s() const;
  double flow_share() const { return params_.flow * mist_ * (1.0 - settles_) * (1.0 - clog_) * open_share_; }
  double level() const { return level_; }            ///< of the vial, 1 = full
  double settles() const { return settles_; }        ///< share of the mist, in the tube
  double open_share() const { return 1.0 - clog_; }  ///< of the nozzle's section, by its own ink
  double gathered_mm3() const { return gathered_mm3_; }
  void io(Archive& a);

 private:
  struct Change {
    std::int64_t t_us = 0;
    bool open = false;
    void io(Archive& a) { a.all(t_us, open); }
  };
  double atomizer(std::int64_t t_us) const;
  void advance(std::int64_t t_us);

  AerosolParams params_;
  std::uint64_t seed_;
  bool drifts_slowly() const { return params_.level_loss > 0.0 || params_.tube_per_h > 0.0; }
  double mist_ = 1.0, clog_ = 0.0, level_ = 1.0, settles_ = 0.0;
  std::int64_t slow_us_ = 0;  ///< time of these
  double gas_, open_share_ = 1.0;
  std::int64_t since_us_ = 0;  ///< first gas; -1 = none yet
  bool commanded_ = false, target_ = false;
  double opening_ = 0.0, gathered_mm3_ = 0.0;
  std::deque<Change> changes_;
  std::int64_t at_us_ = 0;
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace firn::plant
