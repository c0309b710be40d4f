#include "config/checks.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <map>
#include <utility>

#include "config/device_kinds.h"
#include "config/devices.h"
#include "config/error.h"
#include "config/hosts.h"
#include "config/lab_checks.h"
#include "config/labs.h"
#include "config/swaths.h"
#include "core/control/controller.h"
#include "core/control/python_scheme.h"
#include "core/deposition/offset_change.h"
#include "drivers/jet/jet_config.h"

namespace firn {
namespace {

std::string mm(double value) {
  std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 4) + " mm";
}

void check_run(Rules& r) {
  const Experiment& e = r.experiment();
  const std::string& name = e.run.name;
  const bool plain = !name.empty() && name.size() <= 100 && name[0] != '.' &&
                     std::all_of(name.begin(), name.end(), [](unsigned char c) {
                       return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              c == '.' || c == '_' || c == '-';
                     });
  r.require(plain, {"run.name"}, "must be 1 to 100 letters, digits, '_', '-' or '.', and not begin with '.'");
  r.require(2.0 * e.run.safety_period_s <= e.run.lease_s, {"run.safety_period_s", "run.lease_s"},
            "must be at most half of run.lease_s = " + r.value("run.lease_s") +
                ", so that one lost lease stops nothing");
}

// A text of an instrument's dialect goes onto its line: empty it would match anything, and a request is
// short.
void check_dialects(Rules& r) {
  constexpr std::size_t kLongest = 60;
  Experiment e = r.experiment();
  for (const Field& f : fields(e))
    if (const auto* text = std::get_if<std::string*>(&f.value); text && f.key.find(".dialect.") != f.key.npos)
      r.require(!(*text)->empty() && (*text)->size() <= kLongest, {f.key.c_str()},
                "must have 1 to 60 characters");
}

// Ports that are none, and instruments that a trigger line couples across the border of the simulation.
void check_devices(Rules& r) {
  const Experiment& e = r.experiment();
  for (const DevicePort& port : kDevicePorts) {
    if (e.devices.*port.member == kNoInstrument && !takes_part(e, port.node)) continue;
    const std::string key = "devices." + std::string(port.node) + ".port";
    std::string problem;
    PortAddress address;
    try {
      address = parse_port_address(e.devices.*port.member, port.defaults);
    } catch (const std::invalid_argument& error) {
      problem = error.what();
    }
    if (address.pictures() && port.node != "camera") problem = "only a camera has such a port";
    r.require(problem.empty(), {key.c_str()}, problem);
    if (address.kind == PortAddress::Kind::kSimulated) continue;
    r.require(e.run.time_scale == 1.0, {key.c_str(), "run.time_scale"},
              std::string(address.real() ? "a real instrument" : "a cassette") +
                  " keeps the clock's time: run.time_scale must be 1, and is " + r.value("run.time_scale"));
  }
}

// Who speaks with an instrument, and whether its port suits that.
void check_kinds(Rules& r) {
  const Experiment& e = r.experiment();
  for (const DevicePort& port : kDevicePorts) {
    const std::string node(port.node), key = "devices." + node + ".kind",
                                       port_key = "devices." + node + ".port";
    const std::string& at = e.devices.*port.member;
    const bool python = is_python_driver(e, node);
    r.require(at != "python:" || python, {port_key.c_str(), key.c_str()},
              "\"python:\" is the port of a driver class in Python: " + key + " names none");
    r.require(
        !python || at != "sim:" || !takes_part(e, node), {port_key.c_str(), key.c_str()},
        "a driver class in Python speaks with an instrument or a fake of it, not with the simulated world: "
        "name its tcp:, serial: or unix: port, or \"python:\" if the class opens it itself");
  }
  for (const auto& [node, jet] :
       {std::pair<std::string, const drivers::JetConfig*>{"jet", &e.jet}, {"jet_b", &e.jet_b.drive}}) {
    const std::string& kind = device_kind(e, node);
    const std::string key = "devices." + node + ".kind", maker = node + ".kind";
    r.require(kind.empty() || is_python_driver(e, node) || kind == word(jet->kind),
              {key.c_str(), maker.c_str()},
              "must be as " + maker + ", which is \"" + std::string(word(jet->kind)) + "\"");
  }
}

// Names of hosts become names of folders and processes, addresses words of a command line.
void check_hosts(Rules& r) {
  const HostsConfig& hosts = r.experiment().hosts;
  for (const auto& [name, address] : hosts.address) {
    const std::string key = "hosts." + name;
    r.require(is_host_name(name), {key.c_str()}, "the name must be 1 to 40 of a-z, 0-9, '_' and '-'");
    r.require(is_host_address(address), {key.c_str()},
              "must be what ssh calls the computer, as \"user@bench-pc\", without blanks");
  }
  for (const auto& [node, host] : hosts.of_node) {
    if (host.empty() || hosts.address.contains(host)) continue;
    const std::string key = (port_defaults(node) ? "devices." : "nodes.") + node + ".host";
    r.require(false, {key.c_str()},
              "[hosts] has no " + host + ": add " + host + " = \"user@computer\" there");
  }
}

// Names become parts of channels, and names of files.
void check_own_programs(Rules& r) {
  for (const auto& [name, program] : r.experiment().own_programs) {
    const std::string key = "nodes." + name + ".command";
    r.require(is_own_name(name), {key.c_str()}, std::string("the name must be ") + kOwnNameForm);
    r.require(program.command.find_first_not_of(' ') != std::string::npos, {key.c_str()},
              "must be a command");
  }
}

void check_coupled(Rules& r) {
  const Experiment& e = r.experiment();
  const auto outside = outside_ports(e);
  std::map<std::string, std::string> of_kind;  // one instrument of each
  for (const std::string_view node : lab_of(e).coupled) {
    if (!takes_part(e, node)) continue;
    const auto at = outside.find(std::string(node));
    of_kind[at == outside.end() ? "simulated" : at->second.real() ? "real" : "a cassette"] = node;
  }
  if (of_kind.size() < 2) return;
  // "real" before "simulated", and a cassette before both.
  const auto& [other_kind, other] = *of_kind.rbegin();
  const auto& [kind, node] = *std::prev(of_kind.end(), 2);
  const std::string key = "devices." + node + ".port", other_key = "devices." + other + ".port";
  r.require(false, {key.c_str(), other_key.c_str()},
            node + " is " + kind + " and " + other + " " + (other_kind == "real" ? "is " : "") + other_kind +
                ": no trigger line couples them");
}

void check_extent(Rules& r, const char* key, double size_mm, double limit_mm, const char* pitch_key) {
  r.require(size_mm <= limit_mm * (1.0 + 1e-9), {key, pitch_key, "part.shape"},
            "the part does not fit the grid, which is " + mm(limit_mm) + " wide there");
}

void check_part(Rules& r) {
  const Experiment& e = r.experiment();
  const ShapeSpec& s = e.part.shape;
  const bool from_image = s.kind == "height_map";
  r.require(
      from_image == !e.part.image.empty(), {"part.image", "part.shape"},
      from_image ? "part.shape \"height_map\" needs a PNG" : "only part.shape \"height_map\" takes a PNG");
  const bool from_mesh = s.kind == "mesh";
  r.require(from_mesh == !e.part.mesh.empty(), {"part.mesh", "part.shape"},
            from_mesh ? "part.shape \"mesh\" needs a file" : "only part.shape \"mesh\" takes a mesh");
  if (from_image || from_mesh) return;
  const double x_mm = e.grid.nx * e.grid.pitch_x_mm, y_mm = e.grid.ny * e.grid.pitch_y_mm;
  if (s.kind == "cuboid" || s.kind == "wedge") {
    r.require(s.width_mm > 0.0, {"part.width_mm", "part.shape"}, "must be above 0 mm for a " + s.kind);
    r.require(s.depth_mm > 0.0, {"part.depth_mm", "part.shape"}, "must be above 0 mm for a " + s.kind);
    check_extent(r, "part.width_mm", s.width_mm, x_mm, "grid.pitch_x_mm");
    check_extent(r, "part.depth_mm", s.depth_mm, y_mm, "grid.pitch_y_mm");
  } else {
    r.require(s.diameter_mm > 0.0, {"part.diameter_mm", "part.shape"}, "must be above 0 mm for a " + s.kind);
    check_extent(r, "part.diameter_mm", s.diameter_mm, std::min(x_mm, y_mm), "grid.pitch_x_mm");
  }
  if (s.kind == "pipe")
    r.require(s.inner_diameter_mm > 0.0 && s.inner_diameter_mm < s.diameter_mm,
              {"part.inner_diameter_mm", "part.diameter_mm"},
              "must lie between 0 and part.diameter_mm = " + r.value("part.diameter_mm"));
  if (s.kind == "wedge" || s.kind == "cone")
    r.at_most("part.low_height_mm", s.low_height_mm, "part.height_mm", s.height_mm);
}

void check_geometry(Rules& r) {
  const GeometryConfig& g = r.experiment().geometry;
  const bool from_images = g.solid.kind == "images";
  r.require(from_images == !g.images.empty(), {"geometry.images", "geometry.shape"},
            from_images ? "geometry.shape \"images\" needs a folder of PNGs"
                        : "only geometry.shape \"images\" takes PNGs");
  const bool from_mesh = g.solid.kind == "mesh";
  r.require(from_mesh == !g.mesh.empty(), {"geometry.mesh", "geometry.shape"},
            from_mesh ? "geometry.shape \"mesh\" needs a file" : "only geometry.shape \"mesh\" takes a mesh");
}

void check_model(Rules& r) {
  const ModelConfig& m = r.experiment().model;
  r.at_most("model.h2_mm", m.h2_mm, "model.h1_mm", m.h1_mm);
  r.at_most("model.h3_mm", m.h3_mm, "model.h1_mm", m.h1_mm);
  r.at_most("model.g2_mm", m.g2_mm, "model.g1_mm", m.g1_mm);
  r.at_most("model.g3_mm", m.g3_mm, "model.g1_mm", m.g1_mm);
}

// A second size of droplet is a second waveform.
void check_small(Rules& r) {
  const Experiment& e = r.experiment();
  r.require(e.jet.kind == drivers::JetKind::kJetdrive && !is_python_driver(e, "jet"),
            {"actuation.small_share", "jet.kind"}, "this jet has one size of droplet; the JetDrive has two");
  for (const auto& [key, v] : {std::pair("jet.small_dwell_v", e.jet.small_dwell_v),
                               std::pair("jet.small_echo_v", e.jet.small_echo_v)}) {
    r.require(v == std::round(v), {key}, "the jet takes whole volts");
    r.require(std::abs(v) <= e.jet.dialect.max_abs_v, {key, "devices.jet.dialect.max_abs_v"},
              r.value(key) + " is beyond the head's " + r.value("devices.jet.dialect.max_abs_v"));
  }
  r.require(!has_two_jets(e), {"actuation.small_share"},
            "small droplets are of one ink; this experiment prints two");
}

void check_actuation(Rules& r) {
  const Experiment& e = r.experiment();
  std::string problem;
  try {
    deposition::offset_model({e.model.h1_mm, e.model.h2_mm, e.model.h3_mm}, OffsetTable(e.actuation),
                             e.actuation.heights_mm);
  } catch (const std::invalid_argument& why) {
    problem = why.what();
  }
  r.require(problem.empty(), {"actuation.heights_mm", "actuation.offsets"}, problem);
  const bool small = e.actuation.small_share > 0.0;
  r.require(!small || e.actuation.offsets != OffsetKind::kNone,
            {"actuation.small_share", "actuation.offsets"},
            "small droplets are chosen with their places: actuation.offsets = \"x\" or \"grid\"");
  if (e.actuation.offsets == OffsetKind::kNone) return;
  if (small) check_small(r);
  const plant::NatureName* nature = plant::nature_name(e.plant.model);
  r.require(!nature || nature->between_cells, {"actuation.offsets", "plant.model"},
            "plant.model = \"" + e.plant.model +
                "\" has nothing between cells: a droplet beside a centre means nothing there");
  r.require(e.estimator.droplets == "off", {"actuation.offsets", "estimator.droplets"},
            "estimator.droplets learns the height of droplets in the centres alone");
  r.require(e.control.height_estimate != "kalman", {"actuation.offsets", "control.height_estimate"},
            "control.height_estimate = \"kalman\" predicts droplets in the centres alone");
}

void check_passes(Rules& r) {
  const Experiment& e = r.experiment();
  const int s = e.process.sub_patterns;
  r.require(s != 3, {"process.sub_patterns"}, "a layer has 1, 2 or 4 sub-patterns");
  // A pass has a number of seven bits (lcmtypes/stage_command_t.lcm).
  const int drops = e.control.scheme == "mpc"    ? e.control.mpc.max_drops
                    : e.control.scheme == "auto" ? std::max(e.control.mpc.max_drops, e.control.smf.max_drops)
                    : e.control.scheme == "smf"  ? e.control.smf.max_drops
                    : control::is_python_scheme(e.control.scheme) ? control::kMaxPythonDrops
                                                                  : 1;
  const int inks = has_two_jets(e) ? 2 : 1;
  if (s * inks > 1)
    r.require(
        drops * s * inks <= 127, {"process.sub_patterns", "control.mpc.max_drops", "control.smf.max_drops"},
        std::to_string(drops) + " droplets per cell in so many sub-patterns of " + std::to_string(inks) +
            (inks > 1 ? " inks" : " ink") + " are more than 127 passes per layer");
}

void check_estimator(Rules& r) {
  const Experiment& e = r.experiment();
  const bool on = e.estimator.droplets != "off";
  r.require(on || e.control.adapt_model != "on", {"control.adapt_model", "estimator.droplets"},
            "needs estimator.droplets = \"on\", which learns the model");
  r.require(e.estimator.droplets != "camera" || firn::on(e.camera.use), {"estimator.droplets", "camera.use"},
            "needs camera.use = \"on\", which sees the droplets' volume");
  r.require(!on || !has_two_jets(e), {"estimator.droplets"}, "learns one ink; this experiment prints two");
  r.require(!control::is_python_scheme(e.plant.model) || !has_two_jets(e), {"plant.model"},
            "a class in Python prints one ink; this experiment prints two");
  const plant::NatureName* nature = plant::nature_name(e.plant.model);
  r.require(!nature || nature->two_inks || !has_two_jets(e), {"plant.model"},
            "plant.model = \"" + e.plant.model + "\" prints one ink; this experiment prints two");
  r.require(!on || e.control.smoothing == 0.0, {"estimator.droplets", "control.smoothing"},
            "needs the raw map: control.smoothing = 0 (a smoothed one hides what a single droplet does)");
  const bool kalman = e.control.height_estimate == "kalman";
  r.require(!kalman || !has_two_jets(e), {"control.height_estimate"},
            "knows one ink; this experiment prints two");
  r.require(!kalman || e.control.smoothing == 0.0, {"control.height_estimate", "control.smoothing"},
            "needs the raw map, whose noise differs from cell to cell: control.smoothing = 0");
  const bool chooses = e.control.scheme == "auto";
  r.require(!chooses || e.control.adapt_model == "off", {"control.scheme", "control.adapt_model"},
            "auto learns the height of droplets itself: control.adapt_model = \"off\"");
  r.require(
      !chooses || e.actuation.offsets == OffsetKind::kNone, {"control.scheme", "actuation.offsets"},
      "auto chooses among schemes that print the middles of cells: control.scheme = \"mpc\" knows places");
  const bool factors = e.control.droplet_factors != "off";
  r.require(!factors || kalman, {"control.droplet_factors", "control.height_estimate"},
            "needs control.height_estimate = \"kalman\"");
  r.require(!factors || e.control.adapt_model == "off", {"control.droplet_factors", "control.adapt_model"},
            "and control.adapt_model learn the same: one of them only");
}

void check_axis(const Rules& r, double low_mm, double high_mm, const char* what,
                std::initializer_list<const char*> keys, const char* min_key, double min_mm,
                const char* max_key, double max_mm) {
  r.require(low_mm >= min_mm && high_mm <= max_mm, keys,
            std::string(what) + " needs " + mm(low_mm) + " to " + mm(high_mm) + ", outside " + min_key +
                " = " + r.value(min_key) + " to " + max_key + " = " + r.value(max_key));
}

void check_stage(Rules& r) {
  const Experiment& e = r.experiment();
  const StageConfig& s = e.stage;
  const ProcessConfig& p = e.process;
  check_stage_travel(r);
  r.at_most("process.pass_speed_mm_s", p.pass_speed_mm_s, "stage.max_speed_mm_s", s.max_speed_mm_s);
  check_scan_speed(r);
  r.at_most("grid.nx", e.grid.nx, "stage.array_limit", s.array_limit);

  // Nozzle B is above a cell when the stage is short of the cell by the offset.
  const bool two = has_two_jets(e);
  const double bx_mm = two ? e.jet_b.offset_x_mm : 0.0, by_mm = two ? e.jet_b.offset_y_mm : 0.0;
  // A row is run up to its speed outside the part: v^2 / 2a on either side, and one pitch for the arming
  // point.
  const double run_x_mm =
      p.pass_speed_mm_s * p.pass_speed_mm_s / (2.0 * s.acceleration_mm_s2) + e.grid.pitch_x_mm;
  const double run_y_mm =
      p.scan_speed_mm_s * p.scan_speed_mm_s / (2.0 * s.acceleration_mm_s2) + e.grid.pitch_y_mm;
  const double offset_mm = e.laser_profiler.offset_y_mm;
  check_axis(r, e.grid.x_mm(0) - run_x_mm - std::max(0.0, bx_mm),
             e.grid.x_mm(e.grid.nx - 1) + run_x_mm - std::min(0.0, bx_mm),
             two ? "the grid with its run-up and the offset of nozzle B" : "the grid with its run-up",
             {"grid.origin_x_mm", "grid.nx", "grid.pitch_x_mm", "jet_b.offset_x_mm", "stage.x_min_mm",
              "stage.x_max_mm"},
             "stage.x_min_mm", s.x_min_mm, "stage.x_max_mm", s.x_max_mm);
  check_axis(r, e.grid.y_mm(0) - run_y_mm + std::min({0.0, -offset_mm, -by_mm}),
             e.grid.y_mm(e.grid.ny - 1) + run_y_mm + std::max({0.0, -offset_mm, -by_mm}),
             "the grid with its run-up and scan",
             {"grid.origin_y_mm", "grid.ny", "grid.pitch_y_mm", "laser_profiler.offset_y_mm",
              "jet_b.offset_y_mm", "stage.y_min_mm", "stage.y_max_mm"},
             "stage.y_min_mm", s.y_min_mm, "stage.y_max_mm", s.y_max_mm);
  if (two)
    check_axis(r, p.nozzle_gap_mm + std::min(0.0, e.jet_b.offset_z_mm),
               p.nozzle_gap_mm + std::max(0.0, e.jet_b.offset_z_mm), "the gap of nozzle B",
               {"jet_b.offset_z_mm", "process.nozzle_gap_mm", "stage.z_min_mm", "stage.z_max_mm"},
               "stage.z_min_mm", s.z_min_mm, "stage.z_max_mm", s.z_max_mm);
  check_axis(r, p.park_x_mm, p.park_x_mm, "parking",
             {"process.park_x_mm", "stage.x_min_mm", "stage.x_max_mm"}, "stage.x_min_mm", s.x_min_mm,
             "stage.x_max_mm", s.x_max_mm);
  check_axis(r, p.park_y_mm, p.park_y_mm, "parking",
             {"process.park_y_mm", "stage.y_min_mm", "stage.y_max_mm"}, "stage.y_min_mm", s.y_min_mm,
             "stage.y_max_mm", s.y_max_mm);
}

// The jet is watched at one place of the stage.
void check_watch(Rules& r) {
  const Experiment& e = r.experiment();
  const droplet::WatchOptions& w = e.watch;
  const StageConfig& s = e.stage;
  if (!on(e.camera.use)) return;
  r.below("watch.velocity_least_m_s", w.velocity_least_m_s, "watch.velocity_most_m_s", w.velocity_most_m_s);
  if (!on(w.gate) && !on(w.placement)) return;
  check_axis(r, w.x_mm, w.x_mm, "the camera", {"watch.x_mm", "stage.x_min_mm", "stage.x_max_mm"},
             "stage.x_min_mm", s.x_min_mm, "stage.x_max_mm", s.x_max_mm);
  check_axis(r, w.y_mm, w.y_mm, "the camera", {"watch.y_mm", "stage.y_min_mm", "stage.y_max_mm"},
             "stage.y_min_mm", s.y_min_mm, "stage.y_max_mm", s.y_max_mm);
}

void check_instruments(Rules& r) {
  const Experiment& e = r.experiment();
  r.require(e.process.pass_speed_mm_s / e.grid.pitch_x_mm <= e.jet.max_rate_hz,
            {"process.pass_speed_mm_s", "grid.pitch_x_mm", "jet.max_rate_hz"},
            "fires faster than jet.max_rate_hz = " + r.value("jet.max_rate_hz") +
                " at grid.pitch_x_mm = " + r.value("grid.pitch_x_mm"));
  if (has_two_jets(e))
    r.require(e.process.pass_speed_mm_s / e.grid.pitch_x_mm <= e.jet_b.drive.max_rate_hz,
              {"process.pass_speed_mm_s", "grid.pitch_x_mm", "jet_b.max_rate_hz"},
              "fires faster than jet_b.max_rate_hz = " + r.value("jet_b.max_rate_hz") +
                  " at grid.pitch_x_mm = " + r.value("grid.pitch_x_mm"));
  r.at_most("process.exposure_s", e.process.exposure_s, "lamp.max_on_s", e.lamp.max_on_s);
  std::string too_short;
  try {
    swath_shifts_mm(e);
  } catch (const std::invalid_argument& why) {
    too_short = why.what();
  }
  r.require(too_short.empty(),
            {"laser_profiler.dx_mm", "laser_profiler.points", "grid.nx", "grid.pitch_x_mm"}, too_short);
}

}  // namespace

Rules::Rules(const Experiment& experiment, const Origins& origins, const std::string& file,
             std::vector<ConfigError>* all)
    : experiment_(experiment), table_(fields(experiment_)), origins_(origins), file_(file), all_(all) {}

std::string Rules::value(const std::string& key) const {
  const auto f =
      std::find_if(table_.begin(), table_.end(), [&](const Field& field) { return field.key == key; });
  return value_text(*f) + (f->unit.empty() ? "" : " " + std::string(f->unit));
}

void Rules::require(bool ok, std::initializer_list<const char*> keys, const std::string& problem) const {
  if (ok) return;
  Origin place{file_, 0};
  for (const char* key : keys)
    if (const auto o = origins_.find(key); o != origins_.end()) {
      place = o->second;
      break;
    }
  const std::string key = *keys.begin();
  ConfigError error(place.file, place.line, key, key + " = " + value(key) + ": " + problem);
  if (!all_) throw error;
  all_->push_back(std::move(error));
}

void Rules::at_most(const char* key, double actual, const char* limit_key, double limit) const {
  require(actual <= limit, {key, limit_key},
          std::string("must not exceed ") + limit_key + " = " + value(limit_key));
}

void Rules::below(const char* low_key, double low, const char* high_key, double high) const {
  require(low < high, {low_key, high_key},
          std::string("must be below ") + high_key + " = " + value(high_key));
}

void check_stage_travel(const Rules& r) {
  const StageConfig& s = r.experiment().stage;
  r.below("stage.x_min_mm", s.x_min_mm, "stage.x_max_mm", s.x_max_mm);
  r.below("stage.y_min_mm", s.y_min_mm, "stage.y_max_mm", s.y_max_mm);
  r.below("stage.z_min_mm", s.z_min_mm, "stage.z_max_mm", s.z_max_mm);
  const double gap_mm = r.experiment().process.nozzle_gap_mm;
  check_axis(r, gap_mm, gap_mm, "the nozzle's gap",
             {"process.nozzle_gap_mm", "stage.z_min_mm", "stage.z_max_mm"}, "stage.z_min_mm", s.z_min_mm,
             "stage.z_max_mm", s.z_max_mm);
}

void check_scan_speed(const Rules& r) {
  const Experiment& e = r.experiment();
  const double speed = e.process.scan_speed_mm_s;
  r.at_most("process.scan_speed_mm_s", speed, "stage.max_speed_mm_s", e.stage.max_speed_mm_s);
  // The pulse output counts from one row before the first one, where the stage is at rest.
  const double run_up_mm = speed * speed / (2.0 * e.stage.acceleration_mm_s2);
  r.require(run_up_mm <= e.grid.pitch_y_mm * (1.0 + 1e-9),
            {"process.scan_speed_mm_s", "stage.acceleration_mm_s2", "grid.pitch_y_mm"},
            "needs " + mm(run_up_mm) +
                " of run-up at stage.acceleration_mm_s2 = " + r.value("stage.acceleration_mm_s2") +
                ", and has one row: grid.pitch_y_mm = " + r.value("grid.pitch_y_mm"));
  if (has_point_scan(e)) check_point_scan(r);
}

void check_inkjet_lab(Rules& rules) {
  if (!control::is_python_scheme(rules.experiment().control.scheme)) rules.scheme_of(control::schemes());
  check_part(rules);
  check_geometry(rules);
  check_model(rules);
  check_actuation(rules);
  check_passes(rules);
  check_estimator(rules);
  check_stage(rules);
  check_watch(rules);
  check_instruments(rules);
}

void check_experiment(const Experiment& experiment, const Origins& origins, const std::string& file,
                      bool whole, std::vector<ConfigError>* all) {
  Rules rules(experiment, origins, file, all);
  check_run(rules);
  check_dialects(rules);
  check_devices(rules);
  check_kinds(rules);
  check_hosts(rules);
  check_own_programs(rules);
  if (whole) check_coupled(rules);
  lab_of(experiment).check(rules);
}

}  // namespace firn
