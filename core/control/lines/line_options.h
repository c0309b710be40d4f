// LineOptions holds the options of printing lines with a shuttered, continuous flow, with range and meaning
// of each.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "core/motion/aerosol/plan.h"
#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::control {

/// The actuator that the lines' visible width acts on.
enum class WidthActuator { kNone, kSpeed, kGas };
inline constexpr std::array<std::string_view, 3> kWidthActuatorWords{"off", "speed", "gas"};
constexpr std::span<const std::string_view> words_of(WidthActuator) { return kWidthActuatorWords; }

/// The quantity of a line that the speed holds.
enum class HeldQuantity { kSection, kHeight };
inline constexpr std::array<std::string_view, 2> kHeldQuantityWords{"section", "height"};
constexpr std::span<const std::string_view> words_of(HeldQuantity) { return kHeldQuantityWords; }

struct LineOptions {
  int layers = 4;
  motion::CornerMode corner = motion::CornerMode::kLoop;
  double tolerance_mm = 0.05;
  double flow_mm3_s = 0.005;
  double solids = 0.2;
  double line_width_mm = 0.07;
  double station_mm = 1.0;
  double speed_range = 0.3;
  OnOff identify_shutter = OnOff::kOn;
  OnOff feed_forward = OnOff::kOn;
  HeldQuantity hold = HeldQuantity::kSection;
  WidthActuator width_by = WidthActuator::kNone;
  double sheath_range = 0.4;
  double focus_slope = 1.4;
  double spot_x_mm = 0.02, spot_y_mm = 0.05;
  double optical_depth_mm = 0.002;
  double camera_x_mm = 30.0, camera_y_mm = 0.0;
  double camera_um_per_px = 4.0, camera_blur_px = 1.0;
};
inline constexpr OptionTable kLineOptions{
    Option{"layers", &LineOptions::layers, "", within(1, 1000), "times that all lines are printed"},
    Option{"corner", &LineOptions::corner, "", Range{},
           "how connected segments meet: paper: at averaged speeds, shutter open [Thompson 2014, (52)]; "
           "loop: "
           "the shutter closes for a loop; hybrid: rounded within tolerance_mm, else a loop"},
    Option{"tolerance_mm", &LineOptions::tolerance_mm, "mm", within(0, 10),
           "hybrid: largest distance of the path from a corner that it rounds"},
    Option{"flow_mm3_s", &LineOptions::flow_mm3_s, "mm^3/s", above(0, 10), "of ink through the nozzle"},
    Option{"solids", &LineOptions::solids, "", above(0, 1),
           "share of the ink's volume that stays when it is dry"},
    Option{"line_width_mm", &LineOptions::line_width_mm, "mm", above(0, 10),
           "full width of a line at half height: of the nominal surface, and of the band in which ends are "
           "sought"},
    Option{"station_mm", &LineOptions::station_mm, "mm", within(0.2, 100),
           "length of the stretches whose lines are measured and steered apart"},
    Option{"speed_range", &LineOptions::speed_range, "", within(0, 0.9),
           "speeds stay within 1 -+ this share of the segment's", Change::kBetweenLayers},
    Option{"identify_shutter", &LineOptions::identify_shutter, "", Range{},
           "on: the shutter's delays follow from the starts and ends of the printed lines"},
    Option{"feed_forward", &LineOptions::feed_forward, "", Range{},
           "on: the flow of the next layer is foreseen from those of the layers before"},
    Option{"hold", &LineOptions::hold, "", Range{},
           "that the speed holds: section: all of the ink, the halo beside a line too; height: that of the "
           "line's middle"},
    Option{"width_by", &LineOptions::width_by, "", Range{},
           "speed: the lines' width in the camera's pictures acts on the speed, in place of hold; gas: the "
           "width, the camera's or else the profiler's, acts on the sheath's gas, layer by layer"},
    Option{"sheath_range", &LineOptions::sheath_range, "", within(0, 0.9),
           "width_by = gas: the sheath's gas stays within 1 -+ this share of gas.sheath_sccm",
           Change::kBetweenLayers},
    Option{"focus_slope", &LineOptions::focus_slope, "", within(0.1, 20),
           "width_by = gas: relative rise of the sheath's gas for a relative rise of 1 / width^2"},
    Option{"spot_x_mm", &LineOptions::spot_x_mm, "mm", within(0, 1),
           "extent of the profiler's laser spot, by its manual: the lines' heights and widths are held as "
           "seen through it"},
    Option{"spot_y_mm", &LineOptions::spot_y_mm, "mm", within(0, 1), "the same along y"},
    Option{"optical_depth_mm", &LineOptions::optical_depth_mm, "mm", above(0, 1),
           "thickness of dry ink that lets 1/e of the camera's light through"},
    Option{"camera_x_mm", &LineOptions::camera_x_mm, "mm", within(-500, 500),
           "from the nozzle to the middle of the camera's picture"},
    Option{"camera_y_mm", &LineOptions::camera_y_mm, "mm", within(-500, 500), "the same along y"},
    Option{"camera_um_per_px", &LineOptions::camera_um_per_px, "um", within(0.1, 100),
           "scale of the pictures"},
    Option{"camera_blur_px", &LineOptions::camera_blur_px, "", within(0, 10),
           "standard deviation of the optics, by a knife edge"},
};

}  // namespace firn::control
