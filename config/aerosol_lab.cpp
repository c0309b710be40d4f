#include "config/aerosol_lab.h"

#include "config/field_rows.h"
#include "config/lab_checks.h"

namespace firn {
namespace {

constexpr std::string_view kKeys[] = {"run.",
                                      "bus.",
                                      "hosts.",
                                      "nodes.",
                                      "lab.",
                                      "grid.",
                                      "aerosol.",
                                      "stage.",
                                      "laser_profiler.",
                                      "camera.",
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
                                      "process.most_path_error_mm",
                                      "process.beside_mm",
                                      "plant.seed",
                                      "plant.sensor_noise_mm",
                                      "plant.dropout_fraction",
                                      "plant.aerosol.",
                                      "plant.camera.um_per_px",
                                      "plant.camera.width_px",
                                      "plant.camera.height_px",
                                      "plant.camera.blur_px",
                                      "plant.camera.noise",
                                      "plant.camera.light",
                                      "plant.camera.uneven",
                                      "plant.camera.dirt",
                                      "gas.",
                                      "heater.",
                                      "devices.stage.",
                                      "devices.laser_profiler.",
                                      "devices.gas.",
                                      "devices.camera.",
                                      "devices.heater."};
constexpr std::string_view kWithout[] = {"heater.tip_degC", "heater.window_degC", "heater.conduit_degC"};

bool has_gas(const Experiment& e) { return on(e.gas.use); }
bool has_camera(const Experiment& e) { return on(e.camera.use); }
bool has_platen_heater(const Experiment& e) { return e.heater.platen_degC > drivers::kHeaterOff_degC; }

constexpr LabProcess kProcesses[] = {{"stage"},
                                     {"laser_profiler", &has_profiler},
                                     {"gas", &has_gas},
                                     {"heater", &has_platen_heater},
                                     {"camera", &has_camera}};
constexpr std::string_view kCoupled[] = {"stage", "laser_profiler"};

struct LineScheme {
  std::string_view name;
};
constexpr LineScheme kSchemes[] = {{"open_loop"}, {"smf"}};

void check_gas(Rules& r) {
  const GasConfig& g = r.experiment().gas;
  if (!on(g.use)) return;
  for (const auto& [key, unit] :
       {std::pair{"gas.atomizer_unit", &g.atomizer_unit}, {"gas.sheath_unit", &g.sheath_unit}})
    r.require(unit->size() == 1 && (*unit)[0] >= 'A' && (*unit)[0] <= 'Z', {key},
              "must be one letter, A to Z");
  r.require(g.atomizer_unit != g.sheath_unit, {"gas.sheath_unit", "gas.atomizer_unit"},
            "is the atomizer's too: two controllers on one line have two letters");
  r.require(g.atomizer_sccm > 0.0, {"gas.atomizer_sccm", "gas.use"}, "must be above 0: it carries the ink");
  r.require(g.sheath_sccm > 0.0, {"gas.sheath_sccm", "gas.use"},
            "must be above 0: ink without a sheath clogs");
  r.at_most("gas.atomizer_sccm", g.atomizer_sccm, "gas.atomizer_max_sccm", g.atomizer_max_sccm);
  r.at_most("gas.sheath_sccm", g.sheath_sccm, "gas.sheath_max_sccm", g.sheath_max_sccm);
}

void check_platen(Rules& r) {
  const HeaterConfig& h = r.experiment().heater;
  if (!has_platen_heater(r.experiment())) return;
  r.require(h.low_degC < h.platen_degC && h.platen_degC < h.high_degC,
            {"heater.platen_degC", "heater.low_degC", "heater.high_degC"},
            "must lie between heater.low_degC = " + r.value("heater.low_degC") +
                " and heater.high_degC = " + r.value("heater.high_degC"));
}

// Pictures show edges and no heights.
void check_without_profiler(Rules& r) {
  const Experiment& e = r.experiment();
  if (has_profiler(e)) return;
  constexpr const char* kPort = "devices.laser_profiler.port";
  r.require(on(e.camera.use), {kPort, "camera.use"},
            "without a profiler camera.use must be \"on\": nothing else says what lies there");
  r.require(e.aerosol.hold != control::HeldQuantity::kHeight, {"aerosol.hold", kPort},
            "height needs a profiler, and devices.laser_profiler.port is \"none\"");
  r.require(e.control.scheme == "open_loop" || e.aerosol.width_by != control::WidthActuator::kNone,
            {"aerosol.width_by", "aerosol.hold", kPort},
            "hold = section needs a profiler, and devices.laser_profiler.port is \"none\": width_by = speed "
            "or gas, or control.scheme = open_loop");
}

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
  using control::WidthActuator;
  r.require(e.aerosol.width_by != WidthActuator::kSpeed || on(e.camera.use),
            {"aerosol.width_by", "camera.use"}, "needs camera.use = \"on\", which sees the lines' width");
  r.require(e.aerosol.width_by != WidthActuator::kGas || on(e.gas.use), {"aerosol.width_by", "gas.use"},
            "needs gas.use = \"on\", whose sheath focuses the lines");
  r.require(e.aerosol.width_by != WidthActuator::kGas ||
                (1.0 + e.aerosol.sheath_range) * e.gas.sheath_sccm <= e.gas.sheath_max_sccm,
            {"aerosol.sheath_range", "gas.sheath_sccm", "gas.sheath_max_sccm"},
            "must leave the sheath's gas below gas.sheath_max_sccm = " + r.value("gas.sheath_max_sccm"));
  r.require(control::kSmfKp.range.holds(e.control.smf.kp) && e.control.smf.output_limit < 1.0,
            {"control.smf.output_limit", "lab.kind"},
            "must be below 1 where lab.kind = " + r.value("lab.kind"));
  check_without_profiler(r);
  check_stage_travel(r);
  if (has_profiler(e)) check_scan_speed(r);
  if (on(e.camera.use))
    r.at_most("process.pass_speed_mm_s", e.process.pass_speed_mm_s, "stage.max_speed_mm_s",
              e.stage.max_speed_mm_s);
  check_gas(r);
  check_platen(r);
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
  add(t, rows("gas.", e.gas, drivers::kGasConfig));
  add(t, rows("devices.gas.dialect.", e.gas.dialect, drivers::kGasDialect));
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

namespace {

struct Travel {
  double low, high;
};

// The part of `soft` that an axis reaches; a stage that carries the substrate moves against the part's frame.
Travel reached(Travel soft, double low, double high, double origin, bool substrate_moves) {
  const Travel axis =
      substrate_moves ? Travel{origin - high, origin - low} : Travel{low - origin, high - origin};
  return {std::max(soft.low, axis.low), std::min(soft.high, axis.high)};
}

}  // namespace

control::LineSetup line_setup_within_travel(const Experiment& e, const Machine& machine, PrintJob job) {
  control::LineSetup s = line_setup(e, machine, std::move(job));
  const motion::AerosolMachine m = aerosol_machine(machine);
  const Travel x = reached({s.machine.stage_low.x_mm, s.machine.stage_high.x_mm}, m.stage_low.x_mm,
                           m.stage_high.x_mm, m.stage_origin.x_mm, m.substrate_moves),
               y = reached({s.machine.stage_low.y_mm, s.machine.stage_high.y_mm}, m.stage_low.y_mm,
                           m.stage_high.y_mm, m.stage_origin.y_mm, m.substrate_moves);
  s.machine.stage_low = {x.low, y.low};
  s.machine.stage_high = {x.high, y.high};
  return s;
}

const LabKind kAerosolLab{"aerosol",          "the printer of lines with a shuttered aerosol [Thompson 2014]",
                          Deposition::kLines, kKeys,
                          kWithout,           kProcesses,
                          &check_aerosol,     &aerosol_fields,
                          kCoupled,           {"switches", "target", true}};

}  // namespace firn
