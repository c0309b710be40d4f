// The limits of a point laser that the stage moves, by key (docs/devices/point_scan.md).
#include <cstdio>

#include "config/device_kinds.h"
#include "config/lab_checks.h"

namespace firn {
namespace {

constexpr double kMostPointValues_hz = 500.0;  // a value is 14 bytes, 1.2 ms at 115200 baud
constexpr int kLastPointProgram = 7, kMostPointPulses = 1'000'000;

std::string two_numbers(const char* format, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

void check_point_scan(const Rules& r) {
  const Experiment& e = r.experiment();
  const drivers::LaserProfilerConfig& c = e.laser_profiler;
  constexpr const char* kKind = "devices.laser_profiler.kind";
  r.require(c.dx_mm == 0.0, {"laser_profiler.dx_mm", kKind},
            "a point has no line: it measures the middle of each column of the grid; must be 0");
  r.require(!on(c.mirror_x), {"laser_profiler.mirror_x", kKind}, "a point has no sides; must be \"off\"");
  r.require(c.read == drivers::ProfileRead::kNewest, {"laser_profiler.read", kKind},
            "such a laser keeps no profiles; must be \"newest\"");
  r.require(c.program <= kLastPointProgram, {"laser_profiler.program", kKind},
            "an LK-G has the programs 0 to 7");
  const double values_hz = e.process.scan_speed_mm_s / e.grid.pitch_y_mm;
  r.require(values_hz <= kMostPointValues_hz, {"process.scan_speed_mm_s", "grid.pitch_y_mm", kKind},
            two_numbers("gives %.0f values a second, and 115200 baud carry 500: at most %g mm/s", values_hz,
                        kMostPointValues_hz * e.grid.pitch_y_mm));
  const double pulses = double(e.grid.nx) * e.grid.ny;
  r.require(pulses <= kMostPointPulses, {"grid.nx", "grid.ny", kKind},
            two_numbers("a scan has %.0f pulses, at most %.0f", pulses, kMostPointPulses));
  const double low_mm = e.grid.x_mm(0) - c.offset_x_mm, high_mm = e.grid.x_mm(e.grid.nx - 1) - c.offset_x_mm;
  r.require(low_mm >= e.stage.x_min_mm && high_mm <= e.stage.x_max_mm,
            {"laser_profiler.offset_x_mm", "grid.origin_x_mm", "grid.nx", "stage.x_min_mm", "stage.x_max_mm"},
            two_numbers("the spot over each column needs the stage from %g to %g mm", low_mm, high_mm) +
                ", outside stage.x_min_mm = " + r.value("stage.x_min_mm") +
                " to stage.x_max_mm = " + r.value("stage.x_max_mm"));
}

}  // namespace firn
