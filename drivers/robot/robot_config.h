// RobotConfig holds the settings of the robot arm, with range and meaning of each.
#pragma once

#include "core/options/option.h"

namespace firn::drivers {

/// Times that the controller may take: no source gives them.
struct RobotDialect {
  double power_s = 10.0, calibration_s = 90.0;
  double poll_idle_s = 1.0;
};
inline constexpr OptionTable kRobotDialect{
    Option{"power_s", &RobotDialect::power_s, "s", above(0, 600), "longest wait for arm power [P]"},
    Option{"calibration_s", &RobotDialect::calibration_s, "s", above(0, 3600), "and for the calibration [P]"},
    Option{"poll_idle_s", &RobotDialect::poll_idle_s, "s", above(0, 60),
           "between status questions at rest [P]"},
};

struct RobotConfig {
  double travel_mm_s = 200.0;    ///< between paths
  double hb_s = 0.2;             ///< heartbeat of the link; the watchdog of the V+ program is 1.0 s
  double poll_moving_s = 0.1;    ///< between status questions while it moves; events say it sooner
  int block_lines = 4;           ///< path lines sent without waiting for an answer; 1 on a serial line
  double approach_hop_mm = 2.0;  ///< raised so far above the higher end on the way to a path's first point
  double approach_speed_percent = 30.0;
  double raise_on_stop_mm = 10.0;  ///< after a stop, if the tool was at work
  double home_z_mm = 150.0;        ///< joint 3 at rest, after homing at least
  double motion_margin_s = 2.0;  ///< a motion may last so much longer than planned before it has failed (I5)
  RobotDialect dialect = {};     ///< [devices.robot.dialect]
};
inline constexpr OptionTable kRobotConfig{
    Option{"travel_mm_s", &RobotConfig::travel_mm_s, "mm/s", above(0, 1000), "speed between paths"},
    Option{"hb_s", &RobotConfig::hb_s, "s", above(0, 0.5),
           "heartbeat of the link; its watchdog stops the arm after a second without one"},
    Option{"poll_moving_s", &RobotConfig::poll_moving_s, "s", above(0, 10),
           "between status questions while it moves"},
    Option{"block_lines", &RobotConfig::block_lines, "", within(1, 1000),
           "path lines sent without waiting for an answer"},
    Option{"approach_hop_mm", &RobotConfig::approach_hop_mm, "mm", within(0, 200),
           "raised so far above the higher end on the way to a path's first point"},
    Option{"approach_speed_percent", &RobotConfig::approach_speed_percent, "%", within(1, 100),
           "speed on that way"},
    Option{"raise_on_stop_mm", &RobotConfig::raise_on_stop_mm, "mm", within(0, 200), "after a stop"},
    Option{"home_z_mm", &RobotConfig::home_z_mm, "mm", within(0, 210), "joint 3 at rest"},
    Option{"motion_margin_s", &RobotConfig::motion_margin_s, "s", above(0, 100),
           "a motion may last so much longer than planned before it has failed (I5)"},
};

}  // namespace firn::drivers
