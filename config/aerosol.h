// The aerosol lab's configuration: a stage under a shuttered nozzle that prints lines [Thompson 2014]. It
// applies if lab.kind is "aerosol".
#pragma once

#include <string>

#include "core/control/lines/line_options.h"
#include "core/options/option.h"

namespace firn {

struct AerosolLabConfig : control::LineOptions {
  // File paths are relative to the experiment's folder.
  std::string job;      ///< print job of firn plan
  std::string machine;  ///< machine of firn plan, kind "aerosol"
};

/// The simulated nozzle beyond what machine and options say; no controller knows these.
struct AerosolPlantConfig {
  double flow = 1.0;
  double drift = 0.0;
  double drift_spread = 0.0;
  double drift_s = 300.0;
  double wander = 0.01;
  double open_delay_s = 0.03;
  double close_delay_s = 0.045;
  double tail_s = 0.006;
  double blob_s = 0.02;
  double nozzle_mm = 0.28;
  double focusing_ratio = 2.0;
  double overspray = 0.05;
  double halo = 4.0;
  double clog_per_h = 0.02;
  double vial_h = 10.0;
  double level_loss = 0.0;
  double tube_per_h = 0.0;
  double optical_depth_mm = 0.002;
  double camera_dx_mm = 0.0, camera_dy_mm = 0.0;
  double camera_turn_deg = 0.0;
  double servo_hz = 60.0, servo_damping = 0.7, servo_feed_forward = 0.9;
};
inline constexpr OptionTable kAerosolPlant{
    Option{"flow", &AerosolPlantConfig::flow, "", within(0.2, 3),
           "flow of ink at the beginning, in shares of the machine's"},
    Option{"drift", &AerosolPlantConfig::drift, "", within(-0.5, 0.5),
           "relative change of the atomizer's output after drift_s"},
    Option{"drift_spread", &AerosolPlantConfig::drift_spread, "", within(0, 0.5),
           "one more change, minus or plus this, drawn by plant.seed"},
    Option{"drift_s", &AerosolPlantConfig::drift_s, "s", within(1, 1e6), "in which the drift goes linearly"},
    Option{"wander", &AerosolPlantConfig::wander, "", within(0, 0.2),
           "standard deviation of the output's slow random part"},
    Option{"open_delay_s", &AerosolPlantConfig::open_delay_s, "s", within(0, 0.3),
           "from the shutter's switch to the first material"},
    Option{"close_delay_s", &AerosolPlantConfig::close_delay_s, "s", within(0, 0.3),
           "to the end of full flow"},
    Option{"tail_s", &AerosolPlantConfig::tail_s, "s", above(0, 0.3),
           "time constant of the flow's rise and fall after these delays"},
    Option{"blob_s", &AerosolPlantConfig::blob_s, "s", within(0, 1),
           "start-up blob: what gathered at a closed shutter, in seconds of flow"},
    Option{"nozzle_mm", &AerosolPlantConfig::nozzle_mm, "mm", within(0.02, 2), "diameter of the nozzle"},
    Option{"focusing_ratio", &AerosolPlantConfig::focusing_ratio, "", within(0.2, 20),
           "sheath gas by aerosol"},
    Option{"overspray", &AerosolPlantConfig::overspray, "", within(0, 0.5), "share of the ink in the halo"},
    Option{"halo", &AerosolPlantConfig::halo, "", within(1.5, 10), "width of the halo in widths of the line"},
    Option{"clog_per_h", &AerosolPlantConfig::clog_per_h, "1/h", within(0, 5),
           "share of the nozzle's section that closes while ink flows"},
    Option{"vial_h", &AerosolPlantConfig::vial_h, "h", within(0.1, 1000),
           "hours in which the nominal flow empties the atomizer's full vial [U]"},
    Option{
        "level_loss", &AerosolPlantConfig::level_loss, "", within(0, 1),
        "share of its output that the atomizer loses from the full to the empty vial; 0 = the level does not "
        "matter [U]"},
    Option{
        "tube_per_h", &AerosolPlantConfig::tube_per_h, "1/h", within(0, 5),
        "share of the mist that settles in the tube, by which it grows in an hour of nominal flow; 0 = none "
        "[U]"},
    Option{"optical_depth_mm", &AerosolPlantConfig::optical_depth_mm, "mm", above(0, 1),
           "true thickness of dry ink that lets 1/e of the camera's light through"},
    Option{"camera_dx_mm", &AerosolPlantConfig::camera_dx_mm, "mm", within(-1, 1),
           "true place of the camera beyond aerosol.camera_x_mm"},
    Option{"camera_dy_mm", &AerosolPlantConfig::camera_dy_mm, "mm", within(-1, 1), "the same along y"},
    Option{"camera_turn_deg", &AerosolPlantConfig::camera_turn_deg, "deg", within(-5, 5),
           "of the camera about its axis"},
    Option{"servo_hz", &AerosolPlantConfig::servo_hz, "Hz", within(0, 1000),
           "bandwidth of the stage's servo along a path, a damped oscillator; 0: it follows exactly"},
    Option{"servo_damping", &AerosolPlantConfig::servo_damping, "", within(0.1, 5), "its damping ratio"},
    Option{"servo_feed_forward", &AerosolPlantConfig::servo_feed_forward, "", within(0, 1.2),
           "share of the velocity that is fed forward; the rest lags"},
};

}  // namespace firn
