// StageError and NozzleFault compute the faults of stage and nozzle that any nature of the ink-jet lab meets.
#pragma once

#include <cstdint>

#include "core/grid/grid.h"
#include "plant/options/faults.h"
#include "plant/record/archive.h"

namespace firn::plant {

struct TruePlace {
  double x_mm = 0.0, y_mm = 0.0;
};

/// Returns where the stage is when its encoders say (x, y) and x moves at vx:
///   x + stretch_x (x - x0) + cyclic sin(2 pi x / period) - backlash / 2 in the direction of motion, x0 the
///   grid's origin; y likewise with its stretch alone.
TruePlace true_place(const StageFaults& faults, const GridSpec& grid, TruePlace said, double vx_mm_s);

/// The droplets of one trigger.
struct NozzleShot {
  int droplets = 1;
  double dx_mm = 0.0, dy_mm = 0.0;  ///< by which they land beside their place
};

/// Holds one nozzle's faults: rests are counted from its last trigger, and the first trigger of all comes
/// after a rest.
class NozzleFault {
 public:
  explicit NozzleFault(const NozzleFaults& faults) : faults_(faults) {}

  /// @param layer from 1. @param droplets that the drive asks for
  NozzleShot fire(std::int64_t t_us, int layer, int droplets);
  void io(Archive& a) { a.all(last_us_, weak_left_, fired_); }

 private:
  NozzleFaults faults_;
  std::int64_t last_us_ = 0;
  std::int32_t weak_left_ = 0;  ///< droplets still missing after the last rest
  bool fired_ = false;
};

}  // namespace firn::plant
