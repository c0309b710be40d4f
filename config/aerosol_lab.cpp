#include "config/aerosol_lab.h"

#include "config/field_rows.h"
#include "config/lab_checks.h"

namespace firn {
namespace {

constexpr std::string_view kKeys[] = {"run.",
                                      "bus.",
                                      "lab.",
                                      "grid.",
                                      "aerosol.",
                                      "stage.",
                                      "laser_profiler.",
                                      "control.scheme",
                                      "control.smf.kp",
                                      "control.smf.ki_star",
                                      "control.smf.kd_star",
                                      "control.smf.output_limit",
                                      "control.smf.integral_limit",
                                      "process.pass_speed_mm_s",
                                      "process.scan_speed_mm_s",
                                      "process.nozzle_gap_mm",
                                      "process.max_rescans",
                                      "process.min_measured_fraction",
                                      "process.max_lost_rows_share",
                                      "process.least_rise_share",
                                      "process.most_rise_share",
                                      "process.most_beside_share",
                                      "process.beside_mm",
                                      "plant.seed",
                                      "plant.sensor_noise_mm",
                                      "plant.dropout_fraction",
                                      "plant.aerosol.",
                                      "devices.stage.",
                                      "devices.laser_profiler."};
constexpr LabProcess kProcesses[] = {{"stage"}, {"laser_profiler"}};
constexpr std::string_view kCoupled[] = {"stage", "laser_profiler"};

struct LineScheme {
  std::string_view name;
};
constexpr LineScheme kSchemes[] = {{"open_loop"}, {"smf"}};

void check_aerosol(Rules& r) {
  const Experiment& e = r.experiment();
  r.scheme_of(std::span<const LineScheme>(kSchemes));
  r.require(!e.aerosol.job.empty(), {"aerosol.job", "lab.kind"}, "an aerosol lab needs this file");
  r.require(!e.aerosol.machine.empty(), {"aerosol.machine", "lab.kind"}, "an aerosol lab needs this file");
  r.require(e.grid.pitch_x_mm <= 0.5 * e.aerosol.line_width_mm &&
                e.grid.pitch_y_mm <= 0.5 * e.aerosol.line_width_mm,
            {"grid.pitch_x_mm", "grid.pitch_y_mm", "aerosol.line_width_mm"},
            "must be at most half of aerosol.line_width_mm = " + r.value("aerosol.line_width_mm") +
                ", so that the map shows a line's width");
  r.require(control::kSmfKp.range.holds(e.control.smf.kp) && e.control.smf.output_limit < 1.0,
            {"control.smf.output_limit", "lab.kind"},
            "must be below 1 where lab.kind = " + r.value("lab.kind"));
}

}  // namespace

std::vector<Field> aerosol_fields(Experiment& e) {
  using namespace field_rows;
  AerosolLabConfig& c = e.aerosol;
  Table t{
      {"aerosol.job", &c.job, "", path(), "print job of firn plan, path relative to this file"},
      {"aerosol.machine", &c.machine, "", path(), "machine of firn plan, path relative to this file"},
  };
  add(t, rows("aerosol.", static_cast<control::LineOptions&>(c), control::kLineOptions));
  add(t, rows("plant.aerosol.", e.plant.aerosol, kAerosolPlant));
  return t;
}

motion::AerosolMachine aerosol_machine(const Machine& machine) {
  const AerosolConfig& a = machine.aerosol;
  motion::AerosolMachine m;
  m.axis = {a.v_max_mm_s, a.acceleration_mm_s2};
  m.shutter_delay_s = a.shutter_delay_s;
  m.flow_mm3_s = a.flow_mm3_s;
  m.tick_s = a.tick_s;
  m.substrate_moves = a.substrate_moves != 0;
  m.stage_origin = {a.stage_origin_x_mm, a.stage_origin_y_mm};
  m.stage_low = {machine.axis[0].low, machine.axis[1].low};
  m.stage_high = {machine.axis[0].high, machine.axis[1].high};
  return m;
}

control::LineSetup line_setup(const Experiment& e, const Machine& machine, PrintJob job) {
  control::LineSetup s;
  s.job = std::move(job);
  s.machine = aerosol_machine(machine);
  // Ways are in the part's frame, as all commands of the stage are; its own limits hold.
  s.machine.substrate_moves = false;
  s.machine.stage_origin = {};
  s.machine.stage_low = {e.stage.x_min_mm, e.stage.y_min_mm};
  s.machine.stage_high = {e.stage.x_max_mm, e.stage.y_max_mm};
  s.machine.flow_mm3_s = e.aerosol.flow_mm3_s;
  s.options = e.aerosol;
  s.gains = e.control.smf;
  s.output_limit = e.control.smf.output_limit;
  s.feedback = e.control.scheme != "open_loop";
  return s;
}

const LabKind kAerosolLab{"aerosol",
                          "the printer of lines with a shuttered aerosol [Thompson 2014]",
                          Deposition::kLines,
                          kKeys,
                          {},
                          kProcesses,
                          &check_aerosol,
                          &aerosol_fields,
                          kCoupled};

}  // namespace firn
