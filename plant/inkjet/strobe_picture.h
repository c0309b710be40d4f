// StrobePicture renders what a camera sees of a jet under a strobe: physics and optics of its own, which no
// estimator knows.
#pragma once

#include <cstdint>
#include <vector>

#include "plant/inkjet/optics.h"

namespace firn::plant {

struct StrobeSatellite {
  double diameter_um = 12.0;
  double speed_share = 0.9;  ///< of the main droplet's speed at break-off
  double place = 0.6;        ///< between nozzle (0) and main droplet (1) at break-off
};

/// One droplet on its way. It leaves the nozzle at delay 0 with `speed_m_s` and is slowed by the air
/// [Schiller and Naumann 1933].
struct StrobeJet {
  double speed_m_s = 2.0;
  double angle_deg = 0.0;  ///< from the picture's downward axis, positive towards +x
  double diameter_um = 50.0;
  double break_off_us = 60.0;
  double recoil_us = 12.0;   ///< a free tail shrinks into the droplet in this time
  double ligament_um = 8.0;  ///< diameter just before break-off
  double stretch = 0.0;      ///< amplitude of the shape's oscillation along the flight, share of the diameter
  double stretch_period_us = 45.0;
  double jitter_us = 0.0;  ///< standard deviation of the firing time
  std::vector<StrobeSatellite> satellites;
};

struct StrobeCamera : Optics {
  StrobeCamera() {
    blur_px = 1.2;
    light = 0.75;
  }
  double nozzle_x_px = 320.0, nozzle_y_px = 60.0;  ///< middle of its edge
  double nozzle_um = 200.0;                        ///< width; 0: no nozzle in the picture
  double nozzle_taper = 0.0;                       ///< widening per length above the edge
  double opacity = 0.85;                           ///< of droplets and nozzle
  double spot = 0.0,
         spot_radius = 0.25;    ///< brightness of the droplet's bright spot, radius over the droplet's
  bool bright_objects = false;  ///< dark-field light: droplets shine before a dark ground
};

struct StrobeTruth {
  bool drop = false, broken_off = false, inside = false;  ///< inside: wholly in the picture
  double x_px = 0.0, y_px = 0.0, diameter_px = 0.0, delay_us = 0.0;
  double tail_px = 0.0;
  struct Spot {
    double x_px = 0.0, y_px = 0.0, diameter_px = 0.0;
    bool inside = false;
    bool apart = false;  ///< at least 4 px from any other object
  };
  std::vector<Spot> satellites;
};

struct StrobePicture {
  int width = 0, height = 0, white = 255;
  std::vector<std::uint16_t> pixels;  ///< rows from the top
  StrobeTruth truth;
};

/// @param jet nullptr renders the empty scene. @param exposure numbers the picture: another noise and jitter
StrobePicture render_strobe(const StrobeCamera& camera, const StrobeJet* jet, double delay_us,
                            std::uint64_t seed, std::uint32_t exposure);

/// Distance flown [um] and speed [m/s] after `us` of free flight.
struct Flight {
  double um = 0.0, speed_m_s = 0.0;
};
Flight fly(double speed_m_s, double diameter_um, double us);

}  // namespace firn::plant
