// ValveLimits and FlowCurve hold the limits of a micro-solenoid valve with its controller, and its calibrated
// flow [Barnett 2012, 2.3.1, 6.1].
#pragma once

#include <cstdint>
#include <vector>

#include "core/deposition/monotone_curve.h"
#include "core/options/option.h"

namespace firn::deposition {

/// Limits of the pulse list of one path. The list's type is the controller's: 16-bit tick numbers.
struct ValveLimits {
  double tick_s = 0.002;             ///< time resolution of the list [2.3.1]
  double max_duration_s = 131.072;   ///< 65,536 ticks
  std::int32_t max_entries = 16384;  ///< 32 KB
  double min_pulse_s = 0.0005;       ///< the valve's manufacturer [6.1]
  double max_frequency_hz = 1000.0;  ///< the valve's usable maximum [6.1]; a tick of 2 ms allows 500 Hz
  double max_flow_mm3_s = 200.0;     ///< Table 2-2
};
inline constexpr OptionTable kValveLimits{
    Option{"tick_s", &ValveLimits::tick_s, "s", above(0, 1), "resolution of the controller's list [2.3.1]"},
    Option{"max_duration_s", &ValveLimits::max_duration_s, "s", above(0, 65536),
           "longest list; at most 65,536 ticks"},
    Option{"max_entries", &ValveLimits::max_entries, "", within(1, 1e6), "pulses in one list"},
    Option{"min_pulse_s", &ValveLimits::min_pulse_s, "s", above(0, 1), "narrowest pulse the valve follows"},
    Option{"max_frequency_hz", &ValveLimits::max_frequency_hz, "Hz", above(0, 1e5),
           "the valve's own maximum"},
    Option{"max_flow_mm3_s", &ValveLimits::max_flow_mm3_s, "mm^3/s", above(0, 1e6), "Table 2-2"},
};
/// @throws std::invalid_argument naming the limit that is out of its range, or more than 65,536 ticks.
void check(const ValveLimits& limits);

/// Frequency-flow relation nu = h(Q) of one material at one pulse width [6.1, Fig. 6-1, Eq. (6.4)]: the table
/// of the calibration, interpolated monotonically (the thesis: linearly). The origin belongs to every table.
class FlowCurve {
 public:
  struct Row {
    double frequency_hz = 0.0;
    double flow_mm3_s = 0.0;
  };
  /// @throws std::invalid_argument naming the row: at least one above 0, finite, both columns ascending.
  explicit FlowCurve(std::vector<Row> rows);
  /// nu = c_ff Q, the constant of Eq. (5.14). @throws std::invalid_argument: both finite and above 0
  static FlowCurve proportional(double hz_per_mm3_s, double max_frequency_hz);

  double frequency_hz(double flow_mm3_s) const { return h_.at(flow_mm3_s); }  ///< h(Q); clamped to the table
  double flow_mm3_s(double frequency_hz) const { return h_.inverse(frequency_hz); }  ///< h^-1; clamped
  double max_frequency_hz() const { return h_.points().back().y; }
  /// Volume of one drop while the valve delivers `flow`: Q / h(Q); for Q -> 0 its limit 1 / h'(0).
  double drop_mm3(double flow_mm3_s) const;

 private:
  MonotoneCurve h_;
};

/// A pulse width with the curve that was calibrated for it.
struct ValveSetting {
  double pulse_s = 0.00125;
  FlowCurve curve;
};
inline constexpr Option kValvePulse{"pulse_s", &ValveSetting::pulse_s, "s", above(0, 1),
                                    "width of each pulse; the calibration belongs to it"};
/// hz_per_mm3_s of FlowCurve::proportional.
inline constexpr Range kFrequencyPerFlow = above(0, 1e6);
/// @throws std::invalid_argument: pulse out of its range or below min_pulse_s.
void check(const ValveSetting& setting, const ValveLimits& limits);

/// nu_max = 1 / t_pulse [6.1], never above one pulse per tick, the valve's own maximum or the table's end.
double max_frequency_hz(const ValveSetting& setting, const ValveLimits& limits);
/// The flow at that frequency, at most the limits' maximum.
double max_flow_mm3_s(const ValveSetting& setting, const ValveLimits& limits);

}  // namespace firn::deposition
