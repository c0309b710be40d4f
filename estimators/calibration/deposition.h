// When a valve's drops land, and how much it gives at which frequency [Barnett 2012, 5.2.1, 6.1].
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
  Estimate latency_s;         ///< measured = commanded + speed latency + offset
  Estimate offset_mm;         ///< of the nozzle and the map, the same both ways
  FitResult fit;
};
/// @throws Uninformative: fewer than four marks; one speed only (a latency is an offset then)
ValveLatency calibrate_valve_latency(std::span<const LaidMark> marks);

/// Liquid weighed after pulsing at one frequency.
struct FlowWeighing {
  double frequency_hz = 0.0;
  double volume_mm3 = 0.0;
  double duration_s = 0.0;
};
struct FlowCurveRow {
  double frequency_hz = 0.0;
  Estimate flow_mm3_s;
};
struct FlowCurveFit {
  std::vector<FlowCurveRow> rows;  ///< at the weighed frequencies, ascending; a strictly increasing flow
  FitResult fit;                   ///< relative residuals of a drop's volume
};
/// The volume of a drop is a polynomial of third degree in the frequency, fitted to relative differences (balance and pulsation are
/// in proportion); for up to seven frequencies of second degree. @throws Uninformative: fewer than five frequencies, or all within a
/// factor of two; a flow that does not increase; a standard deviation above 5 % at a weighed frequency. std::invalid_argument:
/// a number not above 0
FlowCurveFit calibrate_flow_curve(std::span<const FlowWeighing> weighings);

}  // namespace firn::calibration
