#include "print/labs/aerosol_print.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/aerosol_lab.h"
#include "config/error.h"
#include "config/swaths.h"
#include "core/control/lines/visible_width.h"
#include "core/grid/npy.h"
#include "core/motion/aerosol/check.h"
#include "core/options/for_people.h"
#include "core/path/job_codec.h"
#include "core/path/line_stations.h"
#include "files/digest.h"
#include "files/path/print_job_file.h"
#include "files/usage_error.h"
#include "print/inputs/targets.h"

namespace firn {
namespace {

constexpr double kUmPerMm = 1e3;  // per mm
constexpr double kReach = 4.0;    // sigmas

Blob line_blob(std::string role, std::vector<std::byte> bytes) {
  std::string name = sha256_hex(bytes);
  return {std::move(role), std::move(name), std::move(bytes)};
}

Machine machine_of_lines(const Experiment& e, const std::vector<std::byte>& text) {
  return parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, e.aerosol.machine);
}

Blobs inputs_of(const Experiment& e, const PrintJob& job, std::vector<std::byte> machine) {
  const NominalLines nominal = nominal_lines(e, job);
  return {line_blob("job", encode_job(job)), line_blob("machine", std::move(machine)),
          line_blob("target", to_npy(nominal.target)), line_blob("mask", to_npy(nominal.mask))};
}

/// Travel of the stage along one axis, in the part's frame.
struct AxisTravel {
  const char* name;        ///< "x"
  const char* machine;     ///< its keys in the machine's file
  const char* soft;        ///< its keys in the lab
  double low_mm, high_mm;  ///< reached: the machine's and the soft limits' common part
  double Point2::*along;
};
std::array<AxisTravel, 2> travel_of(const Experiment& e, const Machine& machine) {
  const motion::AerosolMachine m = line_setup_within_travel(e, machine, {}).machine;
  return {{{"x", "axis_1.low_mm, axis_1.high_mm, aerosol.stage_origin_x_mm", "stage.x_min_mm, stage.x_max_mm",
            m.stage_low.x_mm, m.stage_high.x_mm, &Point2::x_mm},
           {"y", "axis_2.low_mm, axis_2.high_mm, aerosol.stage_origin_y_mm", "stage.y_min_mm, stage.y_max_mm",
            m.stage_low.y_mm, m.stage_high.y_mm, &Point2::y_mm}}};
}

// A machine whose travel and the lab's soft limits have nothing in common cannot print.
void check_common_travel(const Experiment& e, const Machine& machine) {
  Experiment alone = e;
  alone.stage.x_min_mm = alone.stage.y_min_mm = -1e9;
  alone.stage.x_max_mm = alone.stage.y_max_mm = 1e9;
  const auto own = travel_of(alone, machine), both = travel_of(e, machine);
  const double soft[2][2] = {{e.stage.x_min_mm, e.stage.x_max_mm}, {e.stage.y_min_mm, e.stage.y_max_mm}};
  for (std::size_t n = 0; n < both.size(); ++n)
    if (both[n].low_mm >= both[n].high_mm) {
      const std::string axis = both[n].name;
      throw UsageError(e.aerosol.machine + ": " + axis + " of the machine, " + motion::text(own[n].low_mm) +
                       " to " + motion::text(own[n].high_mm) + " mm, and stage." + axis +
                       "_min_mm = " + motion::text(soft[n][0]) + " to stage." + axis +
                       "_max_mm = " + motion::text(soft[n][1]) + " mm have no travel in common");
    }
}

/// Refuses a place that the stage does not reach.
void check_reach(const Experiment& e, const std::array<AxisTravel, 2>& travel, const Point2& at,
                 const std::string& what, const std::string& keys) {
  for (const AxisTravel& t : travel)
    if (const double p = at.*t.along; p < t.low_mm - 1e-9 || p > t.high_mm + 1e-9)
      throw UsageError(e.aerosol.machine + ": " + what + " would take the stage's " + t.name + " to " +
                       motion::text(p) + " mm, it reaches " + motion::text(t.low_mm) + " to " +
                       motion::text(t.high_mm) + " mm (" + t.machine + "; of the lab " + t.soft + "); " +
                       keys);
}

// The ends of a scan, and the stops of the camera.
void check_travel(const Experiment& e, const Machine& machine, const PrintJob& job) {
  const std::array<AxisTravel, 2> travel = travel_of(e, machine);
  const GridSpec& g = e.grid;
  if (has_profiler(e)) {
    const std::string keys =
        "grid.origin_x_mm = " + motion::text(g.origin_x_mm) + ", grid.nx = " + std::to_string(g.nx) +
        ", grid.origin_y_mm = " + motion::text(g.origin_y_mm) + ", grid.ny = " + std::to_string(g.ny);
    const double middle_mm = 0.5 * (g.x_mm(0) + g.x_mm(g.nx - 1));
    // As drivers::Stage runs it: from one row before the first to half a row after the last.
    for (const double shift_mm : swath_shifts_mm(e))
      for (const double y_mm : {g.y_mm(0) - g.pitch_y_mm, g.y_mm(g.ny - 1) + 0.5 * g.pitch_y_mm})
        check_reach(e, travel, {middle_mm + shift_mm, y_mm}, "the scan", keys);
  }
  if (!on(e.camera.use)) return;
  const std::string keys = "aerosol.camera_x_mm = " + motion::text(e.aerosol.camera_x_mm) +
                           ", aerosol.camera_y_mm = " + motion::text(e.aerosol.camera_y_mm);
  const auto stop = [&](std::int32_t segment, const Point2& at) {
    check_reach(e, travel, {at.x_mm - e.aerosol.camera_x_mm, at.y_mm - e.aerosol.camera_y_mm},
                "the camera's stop over segments[" + std::to_string(segment) + "]", keys);
  };
  for (const LineStation& s : line_stations(job, e.aerosol.station_mm)) stop(s.segment, s.at);
  if (has_profiler(e)) return;
  for (const LineEnd& end : line_ends(job, 0.0)) stop(end.segment, end.at);
}

double peak_mm(const Experiment& e, double speed_mm_s) {
  const double sigma = e.aerosol.line_width_mm / control::kWidthPerSigma;
  return e.aerosol.flow_mm3_s * e.aerosol.solids / speed_mm_s /
         (sigma * std::sqrt(2.0 * 3.14159265358979324));
}

// Lines that would reach the nozzle.
void check_height(const Experiment& e, const PrintJob& job) {
  for (std::size_t n = 0; n < job.segments.size(); ++n) {
    const double speed = job.segments[n].speed_mm_s, high = e.aerosol.layers * peak_mm(e, speed);
    if (high < e.process.nozzle_gap_mm) continue;
    throw UsageError(e.aerosol.job + ": segments[" + std::to_string(n) + "]: at " + motion::text(speed) +
                     " mm/s aerosol.layers = " + std::to_string(e.aerosol.layers) + " are " +
                     motion::text(high) +
                     " mm high, and process.nozzle_gap_mm = " + motion::text(e.process.nozzle_gap_mm));
  }
}

Blobs make_aerosol_inputs(const Experiment& e, const std::filesystem::path& folder, const MeshInputs*) {
  const PrintJob job = read_print_job(folder / e.aerosol.job);
  std::vector<std::byte> machine = read_bytes(folder / e.aerosol.machine, "aerosol.machine");
  const Machine parsed = machine_of_lines(e, machine);
  if (parsed.kind != "aerosol")
    throw ConfigError((folder / e.aerosol.machine).string(), 0, "aerosol.machine",
                      "aerosol.machine: machine.kind is \"" + parsed.kind + "\", not \"aerosol\"");
  check_common_travel(e, parsed);
  for (const motion::Refusal& r : motion::check_job(job, line_setup_within_travel(e, parsed, {}).machine))
    throw UsageError(e.aerosol.job + ": segments[" + std::to_string(r.segment) + "]: " + r.reason);
  check_height(e, job);
  return inputs_of(e, job, std::move(machine));
}

// Lines that the map does not show, and jobs that no planner can do.
void check_aerosol_inputs(const Experiment& e, const Blobs& inputs) {
  const PrintJob job = decode_job(blob(inputs, "job").bytes);
  const GridSpec& g = e.grid;
  for (std::size_t n = 0; n < job.segments.size(); ++n)
    for (const Point2& p : {job.segments[n].from, job.segments[n].to})
      if (p.x_mm < g.x_mm(0) || p.x_mm > g.x_mm(g.nx - 1) || p.y_mm < g.y_mm(0) || p.y_mm > g.y_mm(g.ny - 1))
        throw UsageError(e.aerosol.job + ": segments[" + std::to_string(n) + "]: (" + for_people(p.x_mm) +
                         ", " + for_people(p.y_mm) + ") mm is beside the grid, x " + for_people(g.x_mm(0)) +
                         " to " + for_people(g.x_mm(g.nx - 1)) + ", y " + for_people(g.y_mm(0)) + " to " +
                         for_people(g.y_mm(g.ny - 1)) + " mm");
  const Machine machine = machine_of_lines(e, blob(inputs, "machine").bytes);
  check_common_travel(e, machine);
  check_travel(e, machine, job);
  try {
    control::LineController(line_setup_within_travel(e, machine, job));
  } catch (const std::invalid_argument& problem) {
    throw UsageError(e.aerosol.job + ": " + problem.what());
  }
}

double layer_um(const Experiment& e) { return peak_mm(e, 3.0) * kUmPerMm; }

Experiment fullest_aerosol() {
  Experiment e;
  e.lab.kind = "aerosol";
  e.control.scheme = "smf";
  e.control.smf.output_limit = 0.5;
  e.aerosol.job = e.aerosol.machine = "-";
  e.gas.use = OnOff::kOn;
  e.heater.platen_degC = 40.0;
  e.camera.use = OnOff::kOn;
  e.grid = {50, 50, 0.02, 0.02, 0.0, 0.0};
  e.process.scan_speed_mm_s = 4.0;
  return e;
}

Blobs example_aerosol_inputs(const Experiment& e) {
  const std::string machine =
      "[machine]\nkind = \"aerosol\"\n[aerosol]\nv_max_mm_s = 4.0\nstage_origin_x_mm = 150.0\n"
      "stage_origin_y_mm = 150.0\n";
  const auto* bytes = reinterpret_cast<const std::byte*>(machine.data());
  return inputs_of(e, {{0.1, 0.5}, {0.9, 0.5}, {{{0.3, 0.5}, {0.7, 0.5}, 3.0}}},
                   {bytes, bytes + machine.size()});
}

}  // namespace

NominalLines nominal_lines(const Experiment& e, const PrintJob& job) {
  NominalLines n{HeightMap(e.grid, 0.0), Mask(e.grid)};
  const double width = e.aerosol.line_width_mm, sigma = width / control::kWidthPerSigma,
               reach = kReach * sigma;
  for (const PrintSegment& s : job.segments) {
    const auto column = [&](double x) { return (x - e.grid.origin_x_mm) / e.grid.pitch_x_mm; };
    const auto row = [&](double y) { return (y - e.grid.origin_y_mm) / e.grid.pitch_y_mm; };
    const int i0 = std::max(0, int(column(std::min(s.from.x_mm, s.to.x_mm) - reach))),
              i1 = std::min(e.grid.nx - 1, int(column(std::max(s.from.x_mm, s.to.x_mm) + reach)) + 1),
              j0 = std::max(0, int(row(std::min(s.from.y_mm, s.to.y_mm) - reach))),
              j1 = std::min(e.grid.ny - 1, int(row(std::max(s.from.y_mm, s.to.y_mm) + reach)) + 1);
    const double peak = e.aerosol.layers * peak_mm(e, s.speed_mm_s);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) {
        const double d = distance_to({e.grid.x_mm(i), e.grid.y_mm(j)}, s);
        if (d > reach) continue;
        double& h = n.target.at(i, j);
        h = std::max(h, peak * std::exp(-0.5 * d * d / (sigma * sigma)));
        if (d <= 0.5 * width) n.mask.at(i, j) = 1;
      }
  }
  return n;
}

const PrintLab kAerosolPrint{"aerosol",
                             &make_aerosol_inputs,
                             nullptr,
                             &check_aerosol_inputs,
                             &layer_um,
                             &fullest_aerosol,
                             &example_aerosol_inputs,
                             &report::kLineReport};

}  // namespace firn
