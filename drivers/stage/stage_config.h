// StageConfig holds the settings of the stage, with range and meaning of each.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

/// program: HomeAsync.bcx in task 5, as the EPICS driver does [C]; command: HOME, which keeps the ASCII
/// interpreter of some firmware busy until the axis is home.
enum class Homing : std::uint8_t { kProgram, kCommand };
inline constexpr std::array<std::string_view, 2> kHomingWords{"program", "command"};
constexpr std::span<const std::string_view> words_of(Homing) { return kHomingWords; }

/// The question for the pulses put out since ARM. It is in no public source [U]. none: the end of the move
/// counts for a whole row, and the droplets of a row that was broken off are in doubt.
enum class PulseCounter : std::uint8_t { kPsocount, kPsostatus, kNone };
inline constexpr std::array<std::string_view, 3> kPulseCounterWords{"PSOCOUNT", "PSOSTATUS", "none"};
constexpr std::span<const std::string_view> words_of(PulseCounter) { return kPulseCounterWords; }

/// Texts and numbers that differ between installations: a table, not code. `@` in a text is the axis.
struct StageDialect {
  std::string ok = "%", nak = "!", fault = "#", timeout = "$";  ///< first character of an answer
  std::string home = "HOME @";
  std::string home_program = "PROGRAM RUN 5, \"HomeAsync.bcx\"", stop_program = "PROGRAM STOP 5";
  int home_count_iglobal = 32, home_axis_iglobal = 33;
  int feedback_input = 0;
  std::string path_program = "PROGRAM RUN 1, \"FirnPath.bcx\"", stop_path_program = "PROGRAM STOP 1";
  int path_count_iglobal = 40;
  int path_period_iglobal = 41, path_samples_iglobal = 42;
  std::string path_track = "PSOTRACK @ INPUT 3,4";
  int pulse_total_us = 50, pulse_on_us = 25;
  double margin_mm = 0.1;
  double tolerance_mm = 0.002;
  int pulse_tolerance_counts = 2;
};
inline constexpr OptionTable kStageDialect{
    Option{"ok", &StageDialect::ok, "", Range{}, "first character of an answer: obeyed; parameter 178 [C]"},
    Option{"nak", &StageDialect::nak, "", Range{}, "not understood; parameter 179 [C]"},
    Option{"fault", &StageDialect::fault, "", Range{}, "a fault; parameter 180 [C]"},
    Option{"timeout", &StageDialect::timeout, "", Range{}, "the controller's own timeout [C]"},
    Option{"home", &StageDialect::home, "", Range{}, "homing = command: @ is the axis [C]"},
    Option{"home_program", &StageDialect::home_program, "", Range{}, "homing = program: starts it [C]"},
    Option{"stop_program", &StageDialect::stop_program, "", Range{}, "and ends it [C]"},
    Option{"home_count_iglobal", &StageDialect::home_count_iglobal, "", within(0, 1000),
           "global integer in which the program finds the number of axes [C]"},
    Option{"home_axis_iglobal", &StageDialect::home_axis_iglobal, "", within(0, 1000), "and the axis [C]"},
    Option{"feedback_input", &StageDialect::feedback_input, "", within(0, 15),
           "encoder that PSOTRACK counts: 0 = the primary one [S]"},
    Option{"path_program", &StageDialect::path_program, "", Range{},
           "starts the program that moves X and Y through the knots of DGLOBAL, 5 numbers each [P]"},
    Option{"stop_path_program", &StageDialect::stop_path_program, "", Range{}, "and ends it [P]"},
    Option{"path_count_iglobal", &StageDialect::path_count_iglobal, "", within(0, 1000),
           "global integer in which that program finds the number of knots [P]"},
    Option{"path_period_iglobal", &StageDialect::path_period_iglobal, "", within(0, 1000),
           "in which it finds the time between two samples of the followed path [ms], 0 = none [P]"},
    Option{"path_samples_iglobal", &StageDialect::path_samples_iglobal, "", within(0, 1000),
           "in which it counts the samples: x, y of each in DGLOBAL behind the knots [P]"},
    Option{"path_track", &StageDialect::path_track, "", Range{},
           "makes the output @ count the way of X and Y together [P]"},
    Option{"pulse_total_us", &StageDialect::pulse_total_us, "us", within(1, 10'000), "of one pulse [S]"},
    Option{"pulse_on_us", &StageDialect::pulse_on_us, "us", within(1, 10'000), "of it on [S]"},
    Option{"margin_mm", &StageDialect::margin_mm, "mm", within(0, 10),
           "run-up and run-out beyond those of the acceleration [P]"},
    Option{"tolerance_mm", &StageDialect::tolerance_mm, "mm", above(0, 1), "of a position read back [P]"},
    Option{"pulse_tolerance_counts", &StageDialect::pulse_tolerance_counts, "", within(0, 1000),
           "by which a pulse may be off so that increments held by the controller serve again [P]"},
};

struct StageConfig {
  double counts_per_mm = 10000.0;
  double acceleration_mm_s2 = 5000.0;  ///< of moves; an ABORT brakes at least as hard
  double max_speed_mm_s = 300.0;
  double x_min_mm = -50.0, x_max_mm = 150.0;
  double y_min_mm = -50.0, y_max_mm = 150.0;
  double z_min_mm = -10.0, z_max_mm = 50.0;
  int array_limit = 8192;
  double poll_moving_s = 0.1;
  double poll_idle_s = 1.0;  ///< the controller closes an idle socket
  double quiet_s = 0.15;
  OnOff home_at_start = OnOff::kOn;
  Homing homing = Homing::kProgram;
  double home_timeout_s = 300.0;
  PulseCounter pulse_count = PulseCounter::kPsocount;
  int first_iglobal = 50;
  OnOff absolute = OnOff::kOn;
  OnOff linear_ramps = OnOff::kOn;
  OnOff pulse_terminal = OnOff::kOn;
  OnOff check_parameters = OnOff::kOn;
  double path_sample_s = 0.01;
  double settle_s = 0.5;
  OnOff laser_output = OnOff::kOff, scan_box = OnOff::kOff;
  double lines_per_s = 150.0;
  StageDialect dialect = {};  ///< [devices.stage.dialect]
};
inline constexpr OptionTable kStageConfig{
    Option{"counts_per_mm", &StageConfig::counts_per_mm, "1/mm", within(1, 1e7), "encoder counts"},
    Option{"acceleration_mm_s2", &StageConfig::acceleration_mm_s2, "mm/s^2", above(0, 1e6), "ramp rate"},
    Option{"max_speed_mm_s", &StageConfig::max_speed_mm_s, "mm/s", above(0, 1e4), "of x and y"},
    Option{"x_min_mm", &StageConfig::x_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"x_max_mm", &StageConfig::x_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"y_min_mm", &StageConfig::y_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"y_max_mm", &StageConfig::y_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"z_min_mm", &StageConfig::z_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"z_max_mm", &StageConfig::z_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"array_limit", &StageConfig::array_limit, "", within(1, 1'000'000),
           "firing distances that the controller holds"},
    Option{"poll_moving_s", &StageConfig::poll_moving_s, "s", above(0, 10),
           "between status questions during a move"},
    Option{"poll_idle_s", &StageConfig::poll_idle_s, "s", above(0, 60), "between status questions at rest"},
    Option{"quiet_s", &StageConfig::quiet_s, "s", above(0, 10),
           "silence that ends the draining of a link after a lost reply [P]"},
    Option{"home_at_start", &StageConfig::home_at_start, "", Range{},
           "off: axes that are not homed stay so until a home command"},
    Option{"homing", &StageConfig::homing, "", Range{},
           "program: HomeAsync.bcx in task 5 [C]; command: HOME, which blocks some firmware [C]"},
    Option{"home_timeout_s", &StageConfig::home_timeout_s, "s", above(0, 3600), "longest homing of one axis"},
    Option{"pulse_count", &StageConfig::pulse_count, "", Range{},
           "question for the pulses since ARM [U]; none: rows that were broken off are in doubt"},
    Option{"first_iglobal", &StageConfig::first_iglobal, "", within(34, 100'000),
           "first global integer of the firing distances; the controller has 50 by default [S]"},
    Option{"absolute", &StageConfig::absolute, "", Range{},
           "ABS is sent before a move, once a connection and a stop: without it LINEAR is incremental [C]"},
    Option{"linear_ramps", &StageConfig::linear_ramps, "", Range{},
           "SCURVE 0 is sent: ramps of constant acceleration, as the run-up has them [S]"},
    Option{"pulse_terminal", &StageConfig::pulse_terminal, "", Range{},
           "PSOOUTPUT CONTROL 1 is sent: pulses leave by the terminal [S]"},
    Option{
        "check_parameters", &StageConfig::check_parameters, "", Range{},
        "the controller's counts per unit, soft limits and global integers are held against these keys [S]"},
    Option{"path_sample_s", &StageConfig::path_sample_s, "s", within(0, 1),
           "between two samples of the position along a path, longer where the controller's memory ends; "
           "whole ms; 0: not recorded"},
    Option{"settle_s", &StageConfig::settle_s, "s", within(0, 60),
           "a path waits so long for the in-position bits of X and Y, then it is refused; 0: not at all"},
    Option{"laser_output", &StageConfig::laser_output, "", Range{},
           "grbl: on: the board's laser output triggers the jet; off: passes are refused [P]"},
    Option{"scan_box", &StageConfig::scan_box, "", Range{},
           "grbl: on: a box that counts the Y steps while the coolant output is on triggers the profiler at "
           "each "
           "pitch; off: scans are refused [P]"},
    Option{"lines_per_s", &StageConfig::lines_per_s, "1/s", within(10, 2000),
           "grbl: lines of G-code that the board takes; a droplet needs two [P]"},
};

}  // namespace firn::drivers
