#include "print/labs/aerosol_print.h"

#include <algorithm>
#include <cmath>

#include "config/aerosol_lab.h"
#include "config/error.h"
#include "core/control/lines/visible_width.h"
#include "core/grid/npy.h"
#include "core/motion/aerosol/check.h"
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

Blobs make_aerosol_inputs(const Experiment& e, const std::filesystem::path& folder) {
  const PrintJob job = read_print_job(folder / e.aerosol.job);
  std::vector<std::byte> machine = read_bytes(folder / e.aerosol.machine, "aerosol.machine");
  const Machine parsed = machine_of_lines(e, machine);
  if (parsed.kind != "aerosol")
    throw ConfigError((folder / e.aerosol.machine).string(), 0, "aerosol.machine",
                      "aerosol.machine: machine.kind is \"" + parsed.kind + "\", not \"aerosol\"");
  for (const motion::Refusal& r : motion::check_job(job, line_setup_within_travel(e, parsed, {}).machine))
    throw UsageError(e.aerosol.job + ": segments[" + std::to_string(r.segment) + "]: " + r.reason);
  return inputs_of(e, job, std::move(machine));
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

// Lines that the map does not show, and jobs that no planner can do.
void check_aerosol_inputs(const Experiment& e, const Blobs& inputs) {
  const PrintJob job = decode_job(blob(inputs, "job").bytes);
  const GridSpec& g = e.grid;
  for (std::size_t n = 0; n < job.segments.size(); ++n)
    for (const Point2& p : {job.segments[n].from, job.segments[n].to})
      if (p.x_mm < g.x_mm(0) || p.x_mm > g.x_mm(g.nx - 1) || p.y_mm < g.y_mm(0) || p.y_mm > g.y_mm(g.ny - 1))
        throw UsageError(e.aerosol.job + ": segments[" + std::to_string(n) + "]: (" + std::to_string(p.x_mm) +
                         ", " + std::to_string(p.y_mm) + ") mm is beside the grid, x " +
                         std::to_string(g.x_mm(0)) + " to " + std::to_string(g.x_mm(g.nx - 1)) + ", y " +
                         std::to_string(g.y_mm(0)) + " to " + std::to_string(g.y_mm(g.ny - 1)) + " mm");
  check_height(e, job);
  try {
    control::LineController(
        line_setup_within_travel(e, machine_of_lines(e, blob(inputs, "machine").bytes), job));
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

const PrintLab kAerosolPrint{
    "aerosol",           &make_aerosol_inputs,          nullptr,          &check_aerosol_inputs,
    &layer_um,           {"switches", "target", false}, &fullest_aerosol, &example_aerosol_inputs,
    &replay::kLineReport};

}  // namespace firn
