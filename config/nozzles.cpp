#include "config/nozzles.h"

#include <algorithm>
#include <cmath>

namespace firn {

double lowest_nozzle_mm(const Experiment& e) {
  const double below_mm = has_two_jets(e) ? std::abs(e.jet_b.offset_z_mm) : 0.0;
  return e.process.nozzle_gap_mm - below_mm;
}

double jets_rate_hz(const Experiment& e) {
  return has_two_jets(e) ? std::min(e.jet.max_rate_hz, e.jet_b.drive.max_rate_hz) : e.jet.max_rate_hz;
}

}  // namespace firn
