#include "plant/twins/profile_sensor.h"

#include <utility>

#include "plant/twins/laser_profiler.h"
#include "plant/twins/point_scan.h"

namespace firn::plant {

std::unique_ptr<ProfileSensor> make_profile_sensor(const GridSpec& grid, const ProfilerParams& params,
                                                   Look look) {
  if (params.point) return std::make_unique<PointScanTwin>(params, std::move(look));
  return std::make_unique<ProfilerTwin>(params, profile_x0_mm(grid, params), profile_dx_mm(grid, params));
}

}  // namespace firn::plant
