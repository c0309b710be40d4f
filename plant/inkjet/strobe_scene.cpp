#include "plant/inkjet/strobe_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

constexpr double kNozzleEdge_px = 40.0;

StrobeCamera camera_of(const WorldConfig& config) {
  const StrobeParams& s = config.strobe;
  StrobeCamera c;
  set_optics(config, 11, c);
  c.nozzle_um = s.nozzle_um;
  c.nozzle_x_px = 0.5 * s.width_px;
  c.nozzle_y_px = std::min(kNozzleEdge_px, 0.2 * s.height_px);
  return c;
}

}  // namespace

void set_optics(const WorldConfig& config, std::uint32_t dirt_key, Optics& c) {
  const StrobeParams& s = config.strobe;
  c.width = s.width_px;
  c.height = s.height_px;
  c.um_per_px = s.um_per_px;
  c.blur_px = s.blur_px;
  c.read_noise = c.shot_noise = s.noise;
  c.light = s.light;
  c.slope_x = 0.5 * s.uneven;
  c.vignette = s.uneven;
  c.flicker = 0.005;
  RandomStream random(config.seed, Purpose::kDisturbance, dirt_key);
  for (int k = 0; k < s.dirt; ++k)
    c.dirt.push_back({random.uniform(0, c.width), random.uniform(0, c.height), random.uniform(1, 5),
                      random.uniform(0.05, 0.5), random.uniform(0.5, 3)});
}

StrobeJet strobe_jet(const WorldConfig& config, double speed_m_s) {
  const StrobeParams& s = config.strobe;
  StrobeJet j;
  j.speed_m_s = speed_m_s;
  j.angle_deg = s.angle_deg;
  j.jitter_us = s.jitter_us;
  j.break_off_us = s.break_off_us;
  j.diameter_um = 1e3 * std::cbrt(6 / std::numbers::pi * config.droplet.volume_mm3 * config.droplet.flow);
  j.ligament_um = std::max(2.5 * s.um_per_px, 0.15 * j.diameter_um);
  for (int k = 0; k < s.satellites; ++k)
    j.satellites.push_back({0.25 * j.diameter_um, 0.9 - 0.05 * k, 0.5 - 0.1 * k});
  return j;
}

double fall_s(const WorldConfig& config, double speed_m_s) {
  const StrobeParams& s = config.strobe;
  if (s.nozzle_gap_mm <= 0.0 || speed_m_s <= 0.0) return 0.0;
  const double gap_um = 1e3 * s.nozzle_gap_mm, diameter_um = strobe_jet(config, speed_m_s).diameter_um;
  double low = 0.0, high = 100.0 * gap_um / speed_m_s;  // [us]
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (low + high);
    (fly(speed_m_s, diameter_um, middle).um < gap_um ? low : high) = middle;
  }
  return high * 1e-6;
}

TakenPicture strobe_scene(const WorldConfig& config, double speed_m_s, const Exposure& exposure) {
  StrobeCamera camera = camera_of(config);
  camera.light *= std::pow(10.0, exposure.gain_db / 20);
  const StrobeJet jet = strobe_jet(config, speed_m_s);
  StrobePicture p = render_strobe(camera, speed_m_s > 0.0 ? &jet : nullptr, exposure.delay_us, config.seed,
                                  exposure.number);
  return {p.width, p.height, p.white, std::move(p.pixels)};
}

}  // namespace firn::plant
