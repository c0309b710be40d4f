#include "print/inputs/check_print.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

#include "config/device_kinds.h"
#include "config/devices.h"
#include "config/labs.h"
#include "files/usage_error.h"
#include "firn/height_map_t.hpp"
#include "plant/world/setup.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

// Rows that a profiler produces faster than a busy machine reads them are lost: a profiler keeps only its
// newest row, and reading takes wall time. Measured: docs/commands/print.md.
void check_rows(const Experiment& e) {
  if (e.laser_profiler.read == drivers::ProfileRead::kMemory || has_point_scan(e)) return;
  constexpr double kMinWall_s = 0.005;
  const double scale = e.run.time_scale, speed = e.process.scan_speed_mm_s, pitch = e.grid.pitch_y_mm,
               row_s = pitch / speed / scale;
  if (scale <= 1.0 || row_s >= kMinWall_s) return;
  const double slowest = pitch / (kMinWall_s * scale), min_scale = pitch / (kMinWall_s * speed);
  throw UsageError(fmt::format(
      "run.time_scale (--speedup) = {:g}: laser_profiler keeps only its newest row, and at "
      "process.scan_speed_mm_s = {:g} over rows of {:g} mm one comes every {:.2f} ms of "
      "wall time; a busy machine loses rows below {:g} ms. Set process.scan_speed_mm_s to at most {:.2f}{}; "
      "--bus in-process loses none at any speed",
      scale, speed, pitch, row_s * 1e3, kMinWall_s * 1e3, std::floor(slowest * 100.0) / 100.0,
      min_scale > 1.0 ? fmt::format(", or --speedup to at most {:.2f}", std::floor(min_scale * 100.0) / 100.0)
                      : std::string()));
}

}  // namespace

void check_print(const Experiment& e, const std::string& bus) {
  if (const auto outside = outside_ports(e); bus == "in-process" && !outside.empty())
    throw UsageError("devices." + outside.begin()->first + ".port = \"" + to_text(outside.begin()->second) +
                     "\": --bus in-process reaches no instrument outside the simulated world");
  if (bus == "in-process" && !e.own_programs.empty())
    throw UsageError("nodes." + e.own_programs.begin()->first +
                     ".command: --bus in-process has no bus for a program of your own");
  for (const auto& [key, value] : {std::pair("control.adapt_model", e.control.adapt_model),
                                   std::pair("flow.feed_forward", e.flow.feed_forward)})
    if (bus == "in-process" && !own_source(value).empty())
      throw UsageError(
          fmt::format("{} = \"{}\": --bus in-process has no bus for a program of your own", key, value));
  try {
    plant::check(plant::world_config(e));
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("nothing to simulate the print with: ") + error.what());
  }
  if (prints_paths(e)) return;  // its maps are of some 10^4 cells, its laser stores a whole path's readings
  if (bus != "in-process") check_rows(e);
  const height_map_t empty{};
  const std::size_t bytes =
      std::size_t(empty.getEncodedSize()) +
      std::size_t(e.grid.nx) * std::size_t(e.grid.ny) * (sizeof empty.height_mm[0] + sizeof empty.quality[0]);
  if (bus != "in-process" && bytes > wire::kLargestObjectBytes)
    throw UsageError(
        fmt::format("grid.nx = {}, grid.ny = {}: a HEIGHT_MAP of {} bytes, the bus takes {} at most; --bus "
                    "in-process has no limit",
                    e.grid.nx, e.grid.ny, bytes, wire::kLargestObjectBytes));
}

}  // namespace firn
