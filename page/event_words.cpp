#include "page/event_words.h"

#include <algorithm>
#include <iterator>

namespace firn::page {
namespace {

constexpr InterlockWords kTable[] = {
    {1, "an emergency stop was pressed",
     "release the button when the lab is safe, then: firn print --resume RUN"},
    {2, "an instrument does not answer",
     "check its power and its cable (firn doctor LAB), then: firn print --resume RUN"},
    {3, "a valve's controller was reset and lost its list",
     "check its power supply; the rest of the list is in doubt and is measured after the resume"},
    {4, "a process of the lab died or hangs", kResume},
    {5, "a motion or a command took too long, or an axis did not follow",
     "look for an obstacle and at the drive's errors, then: firn print --resume RUN"},
    {6, "the nozzle would scrape over the surface",
     "look at the surface below the nozzle; raise the clearance or take the bump away",
     "process.nozzle_clearance_mm, ice.clearance_mm"},
    {7, "a path took more or less time than planned",
     "set the arm's monitor speed to 100; look for what slows it", "ice.max_time_slip_s"},
    {8, "a target lies outside the travel or above the speed limit",
     "check the part's place and the lab file", "stage.max_speed_mm_s"},
    {9, "the lamp was open too long, at the wrong place, cold or faulty",
     "check the lamp's shutter, hours and warm-up", "lamp.max_on_s"},
    {10, "the heater or a thermocouple failed, or a temperature is out of its limits",
     "check the thermocouples and the relay; the channel is off", "heater.low_degC, heater.high_degC"},
    {11, "the jet's waveform is out of range or was changed while jetting", "check the [jet] settings",
     "devices.jet.dialect.max_abs_v, devices.jet.dialect.max_time_us"},
    {12, "the surface did not rise as the droplets say, or rose without droplets",
     "look at the nozzle: clogged, empty or dripping; clean it, then: firn print --resume RUN",
     "process.least_rise_share, process.most_rise_share, ice.least_rise_share"},
    {13, "too little of the surface was measured",
     "clean the profiler's window; lower process.scan_speed_mm_s if rows are lost",
     "process.min_measured_fraction, process.max_lost_rows_share"},
    {14, "not homed, a soft limit, or parameters that contradict the lab file",
     "home the instrument; compare its parameters with the lab file"},
    {15, "the bare table or the first outline is not where it should be", "calibrate: firn calibrate",
     "laser_profiler.bias_limit_mm, laser_profiler.offset_limit_mm, laser_point.bias_limit_mm, "
     "laser_point.offset_limit_mm"},
    {16, "a gas or its sheath was lost, or does not follow its set point",
     "look at the bottle, the lines and the nozzle, then: firn print --resume RUN",
     "gas.lost_share, gas.lost_s, gas.most_pressure_kpa"},
    {17, "the stage, or a place where the shutter switches, is off the planned path",
     "look for an obstacle and at the drive's tuning; the layer is in doubt and is measured after the resume",
     "process.most_path_error_mm"},
};

}  // namespace

std::span<const InterlockWords> interlocks() { return kTable; }

const InterlockWords* interlock_words(int code) {
  const auto row = std::ranges::find(kTable, code, &InterlockWords::code);
  return row == std::end(kTable) ? nullptr : &*row;
}

}  // namespace firn::page
