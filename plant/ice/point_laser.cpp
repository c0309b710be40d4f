#include "plant/ice/point_laser.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

constexpr double kIceSpeed_mm_s = 50.0, kScaffoldSpeed_mm_s = 125.0, kSteep = 0.5;
constexpr double kOutlierShare = 0.01,
                 kOutlierFactor = 8.0;  ///< of the readings on ice, mirror images of the spot

}  // namespace

double laser_reading_mm(const IceLaserParams& p, const Bed& bed, const IceTool& tool, const ArmPose& pose,
                        LaserSettings settings, const LaserKey& key) {
  const ArmPose::Point spot = pose.tool(tool);
  const double true_mm = bed.height_mm(spot.x_mm, spot.y_mm) - spot.z_mm;
  if (std::abs(true_mm) > p.range_mm) return std::copysign(std::numeric_limits<double>::infinity(), true_mm);

  const Ground ground = bed.ground(spot.x_mm, spot.y_mm);
  const double speed = std::sqrt(pose.vx_mm_s * pose.vx_mm_s + pose.vy_mm_s * pose.vy_mm_s);
  double noise_mm = 0.0, dropout = 0.0;
  if (ground == Ground::kWater) {
    const double faster = std::pow(speed / kIceSpeed_mm_s, p.speed_power);
    const bool right = settings == LaserSettings::kIce;
    noise_mm = right ? p.ice_noise_mm * (0.5 + 0.5 * faster) : p.wrong_noise_mm;
    dropout = right ? p.ice_dropout * (0.5 + 0.5 * faster) : p.wrong_dropout;
  } else if (ground == Ground::kScaffold) {
    const double faster = std::pow(speed / kScaffoldSpeed_mm_s, p.speed_power);
    const bool right = settings == LaserSettings::kScaffold;
    noise_mm = right ? p.scaffold_noise_mm * (0.5 + 0.5 * faster) : p.wrong_noise_mm;
    dropout = right ? p.scaffold_dropout * (0.5 + 0.5 * faster) : p.wrong_dropout;
  }
  if (ground != Ground::kTable)
    dropout += p.slope_dropout * std::max(0.0, bed.slope(spot.x_mm, spot.y_mm) - kSteep);
  const auto draw = [&](std::uint32_t which) {
    return DrawKey{key.seed, which < 2 ? Purpose::kDropout : Purpose::kSensorNoise, 2000 + key.storage, which,
                   key.sample};
  };
  if (random_uniform(draw(0)) < std::min(dropout, 0.98)) return std::numeric_limits<double>::quiet_NaN();
  const bool outlier = ground == Ground::kWater && random_uniform(draw(1)) < kOutlierShare;
  const double share = true_mm / p.range_mm;
  const double bent_mm = p.linearity * 2.0 * p.range_mm * share * share * share;
  return true_mm + bent_mm + noise_mm * (outlier ? kOutlierFactor : 1.0) * random_normal(draw(2)) +
         p.repeatability_mm * random_normal(draw(3));
}

}  // namespace firn::plant
