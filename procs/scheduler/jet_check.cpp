#include "procs/scheduler/jet_check.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/vision/flight.h"
#include "firn/enums.h"

namespace firn {
namespace {

constexpr double kMax_mm = 10.0;  // of a lead: the range of stage_command_t

Violation outside(const char* what, double value, double std, const char* unit, const char* key,
                  double limit) {
  char text[160];
  std::snprintf(text, sizeof text, "its %s is %.3g +- %.2g%s%s, %s = %g", what, value, std, *unit ? " " : "",
                unit, key, limit);
  return {text, {value, limit, unit, key}};
}

bool has(const droplet_sweep_t& m, SweepValue v) { return m.known & std::int32_t(v); }

}  // namespace

Violation jet_out_of_band(const droplet_sweep_t& m, const droplet::WatchOptions& o) {
  if (m.with_droplet == 0)
    return {"no droplet in " + std::to_string(m.frames) + " pictures: the nozzle is dead or clogged"};
  if (m.um_per_px == 0.0) return {"the pictures have no scale: set watch.um_per_px or watch.nozzle_um"};
  if (!has(m, SweepValue::kVelocity))
    return {"its velocity is not known: droplets in " + std::to_string(m.with_droplet) + " of " +
            std::to_string(m.frames) + " pictures, free ones in " + std::to_string(m.used)};
  const double v = m.velocity_mm_s * 1e-3, v_std = m.velocity_std_mm_s * 1e-3;
  if (v < o.velocity_least_m_s)
    return outside("velocity", v, v_std, "m/s", "watch.velocity_least_m_s", o.velocity_least_m_s);
  if (v > o.velocity_most_m_s)
    return outside("velocity", v, v_std, "m/s", "watch.velocity_most_m_s", o.velocity_most_m_s);
  const double degrees = 180.0 / std::numbers::pi, angle = m.angle_rad * degrees;
  if (std::abs(angle) > o.angle_most_deg)
    return outside("angle", angle, m.angle_std_rad * degrees, "deg", "watch.angle_most_deg",
                   o.angle_most_deg);
  if (m.satellites > o.satellites_most)
    return outside("number of satellites", m.satellites, m.satellites_std, "", "watch.satellites_most",
                   o.satellites_most);
  return {};
}

double lead_of(const droplet_sweep_t& m, double stage_speed_mm_s, double gap_mm) {
  if (!has(m, SweepValue::kVelocity)) return 0.0;
  const vision::Flyer flyer{m.velocity_mm_s, m.middle_us * 1e-6,
                            has(m, SweepValue::kDiameter) ? m.diameter_mm : 0.0};
  const double lead_mm = stage_speed_mm_s * vision::flight_time_s(flyer, gap_mm);
  return lead_mm <= kMax_mm ? lead_mm : 0.0;  // false for infinity
}

}  // namespace firn
