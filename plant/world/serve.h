// serve() runs the world as a process: ports as Unix sockets, a control line to the launcher, the run's
// clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "plant/config/world_config.h"

namespace firn::plant {

struct ServeOptions {
  std::filesystem::path run;  ///< the run folder
  std::filesystem::path io;   ///< folder of the sockets; default run/io
  int control_fd = -1;        ///< -1: no control line, the process ends at SIGTERM
  std::int64_t epoch_ns = 0;  ///< CLOCK_BOOTTIME at which world time is offset_us
  std::int64_t offset_us = 0;
  double time_scale = 1.0;                                 ///< world seconds per wall second
  double line_speed = 1.0;                                 ///< as WorldConfig's
  bool steady = false;                                     ///< see make_steady()
  bool quick = false;                                      ///< instruments that start without delay
  std::vector<std::pair<std::string, std::string>> blobs;  ///< inputs: role and digest
  std::set<std::string, std::less<>>
      elsewhere;  ///< ports that are not served: they have an address of their own
};

/// Reads "--run DIR [--io DIR] [--control-fd N] [--epoch-ns E] [--offset-us O] [--time-scale S]
/// [--line-speed F] [--nature steady] [--instruments quick] [--port NAME=ADDRESS]…": such a port is not
/// served;
/// [--blob ROLE=DIGEST]…: inputs of the run.
/// --incarnation, --run-id, --bus, --node, which every process of a run receives, are accepted and not used.
/// @throws std::invalid_argument naming the argument and its required form
ServeOptions parse_serve_options(const std::vector<std::string>& arguments);

/// Serves until the control line closes or says STOP, or SIGTERM; then saves run/world/state and returns.
/// Goes on from that state when it exists; see kept_world.h for a world that was killed. Record:
/// run/world.rec. Control line, one text line each:
///   up    READY                     the sockets are there
///   down  TRUTH                     up: see truth_line()
///   down  WEIGH material weighing   up: "WEIGHED mg" of the ice lab's cup, or "ERROR text"
///   down  SIMFAULT port kind [count [delay_us]]   (twins/fault.h); up: "OK" or "ERROR text"
///   down  START                     nothing: the world runs by its clock
///   down  STOP [cause]
/// @throws std::runtime_error: socket path longer than 107 bytes, port in use, state damaged
void serve(const ServeOptions& options, const WorldConfig& config);

struct Truth;
/// Returns "TRUTH layer droplets volume_mm3 nx ny pitch_x_mm pitch_y_mm origin_x_mm origin_y_mm h…", numbers
/// with a fraction as C hexadecimal floats, nx ny heights [mm], row-major.
std::string truth_line(const Truth& truth);

}  // namespace firn::plant
