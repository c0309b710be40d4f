#include "procs/scheduler/scan_commands.h"

#include "lcmtypes/convert.h"

namespace firn {

stage_command_t scan_command(const Experiment& e, const Swath& swath, double speed_mm_s) {
  const GridSpec& g = e.grid;
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kScan);
  c.attempt = swath.attempt;
  c.scan_id = swath.scan_id;
  c.rows = g.ny;
  c.x_mm = 0.5 * (g.x_mm(0) + g.x_mm(g.nx - 1)) + swath.shift_mm;  // the line's middle
  c.y_mm = g.y_mm(0) - e.laser_profiler.offset_y_mm;               // the line over the first row
  c.z_mm = e.process.nozzle_gap_mm;
  c.speed_mm_s = speed_mm_s;
  c.grid = to_message(g);
  return c;
}

profiler_command_t profiler_command(const Experiment& e, const Swath& swath, ProfilerVerb verb) {
  profiler_command_t c{};
  c.verb = std::int8_t(verb);
  c.attempt = swath.attempt;
  c.scan_id = swath.scan_id;
  c.rows = e.grid.ny;
  c.y0_mm = e.grid.y_mm(0);
  c.pitch_y_mm = e.grid.pitch_y_mm;
  c.first_row = std::int32_t(swath.number) * c.rows;
  c.rows_of_scan = std::int32_t(swath.count) * c.rows;
  c.shift_x_mm = swath.shift_mm;
  return c;
}

double scan_time_s(const Experiment& e, double speed_mm_s) {
  return (e.grid.ny + 1) * e.grid.pitch_y_mm / speed_mm_s + 10.0;
}

}  // namespace firn
