#include "config/nozzles.h"

#include <cmath>

namespace firn {

double lowest_nozzle_mm(const Experiment& e) {
  const double below_mm = has_two_jets(e) ? std::abs(e.jet_b.offset_z_mm) : 0.0;
  return e.process.nozzle_gap_mm - below_mm;
}

}  // namespace firn
