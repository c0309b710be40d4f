// Estimates a valve's latency, and its flow against the pulse frequency [Barnett 2012, 5.2.1, 6.1].
#pragma once

#include <span>
#include <vector>

#include "estimators/calibration/robust_fit.h"

namespace firn::calibration {

/// The middle of a short mark that was laid while the nozzle moved along one axis.
struct LaidMark {
  double commanded_mm = 0.0;  ///< where the nozzle was, on the commanded path, at the middle of its pulses
  double measured_mm = 0.0;   ///< where its centre of mass was found
  double speed_mm_s = 0.0;    ///< signed
};
struct ValveLatency {
  Estimate latency_s;  ///< measured = commanded + speed latency + offset
  Estimate offset_mm;  ///< of the nozzle and the map, the same both ways
  FitResult fit;
  std::vector<double> off_mm;  ///< each mark's residual
};
/// @throws Unidentifiable: fewer than four marks; one speed only (a latency is an offset then)
ValveLatency calibrate_valve_latency(std::span<const LaidMark> marks);

/// Liquid weighed after pulsing at one frequency.
struct FlowWeighing {
  double frequency_hz = 0.0;
  double volume_mm3 = 0.0;
  double duration_s = 0.0;
  /// Entry k: share of the pulses that come k + 1 ticks after the one before, the last entry: or later. All
  /// weighings or none.
  std::vector<double> gap_share = {};
  double warmth = 0.0;       ///< of the coil, of any unit: mean pulse rate of the minutes before
  double warmth_lag = 0.0;   ///< that of a coil which takes longer to warm, less `warmth`: how long the true
                             ///< one takes is not known
  double warmer_K = 0.0;     ///< the tip beyond its set point
  double balance_mm3 = 0.0;  ///< standard deviation of the volume from weighing;
                             ///< the flow's own noise falls off with the root of the duration
};
/// @throws Unidentifiable: fewer than five frequencies, or all within a factor of two
void check_flow_frequencies(std::vector<double> frequencies_hz);

struct FlowCurveRow {
  double frequency_hz = 0.0;
  Estimate flow_mm3_s;
};
struct FlowCurveFit {
  std::vector<FlowCurveRow> rows;  ///< at the weighed frequencies, ascending; a strictly increasing flow
  FitResult fit;                   ///< relative residuals of a drop's volume
  std::vector<double> relative;    ///< each weighing's
  double warmth = 0.0;             ///< that the rows hold for
};
/// With gap shares: a list on a raster of ticks has whole gaps only, and a drop's volume depends on the gap
/// before it; so the mean drop is S = sum_g share_g V_g, times 1 + k_p nu S (pressure that the flow takes),
/// times 1 + k_w warmth + k_l warmth_lag + k_T warmer_K (a warm coil opens longer, warm liquid flows more
/// easily; left out where all are 0); the rows are those of a coil that has long been as warm as the
/// weighings' mean, and the set point: a cold coil would be an extrapolation. A gap class of less than half a
/// per cent of all pulses joins the next longer. Without: the volume of a drop is a polynomial of third
/// degree in the frequency, fitted to relative differences, which count by the root of their duration
/// (pulsation averages out); for up to seven frequencies of second degree. @throws Unidentifiable: fewer than
/// five frequencies, or all within a factor of two; a flow that does not increase; a standard deviation above
/// 5 % at a weighed frequency. std::invalid_argument: a number not above 0
FlowCurveFit calibrate_flow_curve(std::span<const FlowWeighing> weighings);

}  // namespace firn::calibration
