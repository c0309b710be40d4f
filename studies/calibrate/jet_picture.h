// jet_picture draws the velocities that firn calibrate jet measured, against dwell time and voltage.
#pragma once

#include <string>
#include <vector>

#include "estimators/calibration/jet_waveform.h"

namespace firn {

struct JetSweeps {
  std::vector<calibration::JetSpeed> by_dwell, by_voltage;
  calibration::BestDwell dwell;
  calibration::VoltageLine line;
  double wanted_m_s = 0.0;
  double proposed_us = 0.0, proposed_v = 0.0;
};

/// One <svg>: measured velocities with 95 % bars, the fitted curves and the proposal.
std::string jet_picture(const JetSweeps& sweeps);

}  // namespace firn
