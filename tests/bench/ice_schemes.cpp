// Feedback schemes of the ice printer against the simulated nature, without drivers, bus and scheduler:
// planner, valves, arm, laser, mapper, control law. RMS of the true surface against the nominal height over
// the cells that are judged (replay/report_ice_data.h) and inside the part, per interval.
//
// Parts: a disc whose rings fit it, the gear of bench/ice_gear.h, or the part of an experiment.
//   build/bench/ice_schemes [--intervals N] [--seeds N] [--first-seed N] [--drift D] [--staggered | --gear
//   [--size S] | --experiment FILE [--set KEY=VALUE]...]
//                           [--spacing MM] [--scheme NAME,NAME] [--each] [--map measured|raw|true] [--picture
//                           SVG]
// --map: input of the law: the smoothed map, the same without smoothing, or the true surface. --picture:
// true error of the last interval, orange too high, blue too low, +-0.4 mm. Schemes: open, smf_speed [1 0.25
// 0.25], smf_thesis [1 0.25 0.25], smf_optimal [1 0.32798 0.00005], adaptive, ..._flow (feed-forward),
// adaptive:KP:GAIN:RATE, own: that of the experiment
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/ice_lab.h"
#include "config/include.h"
#include "core/control/surface/surface_controller.h"
#include "core/planning/path_planning.h"
#include "core/slice/coverage/footprint.h"
#include "estimators/flow/flow_estimator.h"
#include "estimators/flow/laid_volume.h"
#include "estimators/surface/path_readings.h"
#include "plant/ice/nature.h"
#include "plant/world/setup.h"
#include "print/folder/run_folder.h"
#include "print/inputs/ice_inputs.h"
#include "report/draw/heat_map.h"
#include "report/run/report_ice_data.h"
#include "tests/bench/ice_gear.h"
#include "tests/bench/ice_zones.h"

namespace {

using namespace firn;

struct Settings {
  int intervals = 26, seeds = 3, first_seed = 1;
  double drift = 0.0, size = 1.0, spacing_mm = 4.0;
  bool gear = false, staggered = false;
  bool each = false;
  std::string experiment, map = "measured", picture;
  std::vector<std::string> overrides;
  std::string schemes = "open,smf_thesis,smf_optimal,adaptive";
};

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// As weighed on the bench: cold coil, no drift.
deposition::FlowCurve curve_of(const plant::IceLineParams& params, int valve) {
  const plant::Line line(params, 1, valve);
  std::vector<deposition::FlowCurve::Row> rows;
  for (double hz = 5.0; hz <= 500.0; hz += 15.0)
    rows.push_back({hz, hz * line.steady_pulse_mm3(hz, 0.00125)});
  return deposition::FlowCurve(rows);
}

constexpr double kLag_s = 0.0284;  // start delay and servo
constexpr double kLaserLatency_s = 0.0008 - kLag_s;
constexpr double kValveLatency_s = 0.0015 - kLag_s;

planning::PlanningSetup setup_of(const plant::IceWorldConfig& c, bool speed) {
  planning::PlanningSetup s;
  const Machine machine = parse_machine("[machine]\nname = \"cobra600\"\n", "bench");
  s.arm = planning_arm(machine);
  s.laser = s.arm.tools[3];
  s.origin = {c.arm.origin_mm[0], c.arm.origin_mm[1]};
  s.origin_z_mm = c.arm.origin_mm[2];
  const double v = speed ? 25.0 : 60.0;
  s.speeds = {{{v, v, 50.0}, {v, v, 125.0}}};
  s.valve_limits = valve_limits(machine.valve);
  s.valve_limits.max_duration_s = 130.0;
  for (int valve = 0; valve < 2; ++valve)
    s.valves.push_back({{0.00125, curve_of(c.line[std::size_t(valve)], valve)}, kValveLatency_s});
  s.version = speed ? control::SurfaceVersion::kPathSpeed : control::SurfaceVersion::kValveFrequency;
  return s;
}

std::vector<plant::Joints> joints_of(const Trajectory& t) {
  std::vector<plant::Joints> q(t.samples());
  for (std::size_t n = 0; n < q.size(); ++n)
    for (std::size_t a = 0; a < 4; ++a) q[n][a] = t.positions[4 * n + a];
  return q;
}

class Lab {
 public:
  Lab(const plant::IceWorldConfig& c, std::uint64_t seed) : config_(c), nature_(c, seed) {}

  void run(const planning::PlannedTask& p, int valve, double pulse_s) {
    for (std::size_t n = 0; n < p.lists.size(); ++n) {
      const std::size_t from = std::size_t(std::llround(p.lists[n].start_s / p.trajectory.tick_s));
      const std::size_t to = n + 1 < p.lists.size()
                                 ? std::size_t(std::llround(p.lists[n + 1].start_s / p.trajectory.tick_s))
                                 : p.trajectory.samples() - 1;
      std::vector<plant::Joints> all = joints_of(p.trajectory);
      begin({all.begin() + std::ptrdiff_t(from), all.begin() + std::ptrdiff_t(to + 1)});
      plant::Firing list;
      list.pulse_s = pulse_s;
      for (const std::int32_t tick : p.lists[n].ticks) list.ticks.push_back(std::uint16_t(tick));
      if (!list.ticks.empty()) nature_.trigger_valve(valve, now_s(), std::move(list));
      finish(p.trajectory.tick_s * double(to - from));
      nature_.close_valve(valve);
    }
  }

  std::vector<float> measure(const planning::PlannedTask& p, int material) {
    begin(joints_of(p.trajectory));
    nature_.begin_storage(now_s() + config_.laser.trigger_delay_s, 0.01, 65536,
                          material == 0 ? plant::LaserSettings::kIce : plant::LaserSettings::kScaffold);
    finish(p.trajectory.certificate.duration_s);
    nature_.end_storage();
    std::vector<float> z = nature_.storage().mm;
    for (float& v : z)
      if (!std::isfinite(v)) v = std::numeric_limits<float>::quiet_NaN();
    return z;
  }
  HeightMap truth(const GridSpec& g) const { return nature_.bed().mean_over(g); }
  double hours() const { return now_s() / 3600.0; }

 private:
  double now_s() const { return double(now_us_) * 1e-6; }
  void begin(std::vector<plant::Joints> points) {
    now_us_ += 1'500'000;  // travel
    nature_.catch_up(now_us_);
    nature_.arm().place(points.front());
    nature_.arm().follow(std::move(points), 0.016,
                         now_s() + config_.arm.start_delay_s + 0.5 * config_.arm.start_jitter_s);
  }
  void finish(double duration_s) {
    now_us_ += std::int64_t((duration_s + 0.2) * 1e6);
    nature_.catch_up(now_us_);
  }
  plant::IceWorldConfig config_;
  plant::IceNature nature_;
  std::int64_t now_us_ = 1'000'000;
};

struct Scheme {
  control::SurfaceOptions options;
  bool speed = false;
};

Scheme scheme_named(std::string name) {
  Scheme s;
  if (const std::size_t at = name.find(':'); at != std::string::npos) {  // adaptive:KP:GAIN:RATE
    std::sscanf(name.c_str() + at, ":%lf:%lf:%lf", &s.options.adaptive.kp, &s.options.adaptive.gain,
                &s.options.adaptive.gain_rate);
    s.options.smf.kp = s.options.adaptive.kp;
    name.resize(at);
  }
  if (name.ends_with("_flow")) {
    s.options.feed_forward = true;
    name.resize(name.size() - 5);
  }
  s.options.version = control::SurfaceVersion::kValveFrequency;
  s.options.output_limit = 0.6;
  const double kp = s.options.smf.kp;
  s.options.smf = {kp, 0.25, 0.25, 0.5};
  if (name == "open")
    s.options.scheme = "open_loop";
  else if (name == "smf_speed") {
    s.speed = true;
    s.options.version = control::SurfaceVersion::kPathSpeed;
  } else if (name == "smf_optimal")
    s.options.smf = {0.9999 * kp, 0.32798, 0.00005, 0.5};
  else if (name == "adaptive")
    s.options.scheme = "smf_adaptive";
  else if (name == "adaptive_fixed") {
    s.options.scheme = "smf_adaptive";
    s.options.adaptive.gain_rate = 0.0;
  } else if (name == "adaptive_speed") {
    s.options.scheme = "smf_adaptive";
    s.speed = true;
    s.options.version = control::SurfaceVersion::kPathSpeed;
  } else if (name != "smf_thesis") {
    std::fprintf(stderr, "unknown scheme %s\n", name.c_str());
    std::exit(2);
  }
  return s;
}

/// Holds the printed part and the lab's beliefs of itself.
struct Job {
  slice::PrintPaths paths;
  int interval_layers = ice_gear::kInterval_layers;
  bool map_table = false;
  plant::IceWorldConfig world;
  planning::PlanningSetup setup[2];  ///< frequency, speed
  double laser_latency_s = kLaserLatency_s, period_s = 0.01;
  surface::ScatterOptions scatter;
  control::SurfaceOptions options;  ///< of the experiment
};

Job job_of(const Settings& o) {
  Job j;
  if (o.experiment.empty()) {
    j.paths = o.gear ? ice_gear::print(o.intervals, o.size, o.spacing_mm)
                     : ice_gear::print_disc(o.intervals, o.spacing_mm, o.staggered);
    for (int speed = 0; speed < 2; ++speed) j.setup[speed] = setup_of(j.world, speed != 0);
    return j;
  }
  std::vector<std::string> overrides = o.overrides;
  Experiment e = load_experiment(o.experiment, overrides);
  e.ice.height_mm = o.intervals * e.ice.interval_layers * e.ice.layer_height_mm;
  const Blobs inputs = make_ice_inputs(e, std::filesystem::path(o.experiment).parent_path());
  place_ice_field(e, inputs);
  j.paths = slice::decode_print_paths(blob(inputs, "paths").bytes);
  j.interval_layers = e.ice.interval_layers;
  j.map_table = e.ice.map_table == "on";
  j.world = plant::world_config(e).ice;
  j.laser_latency_s = e.laser_point.latency_s;
  j.period_s = 1.0 / e.laser_point.rate_hz;
  j.scatter = {e.ice.measure_spacing_mm, e.control.smoothing > 0.0, e.ice.map_samples};
  const std::vector<std::byte>& text = blob(inputs, "machine").bytes;
  const Machine machine = parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, "machine");
  j.options = surface_options(e, 0);
  for (int speed = 0; speed < 2; ++speed) {
    e.control.surface.version =
        speed ? control::SurfaceVersion::kPathSpeed : control::SurfaceVersion::kValveFrequency;
    j.setup[speed] = planning_setup(e, machine);
  }
  return j;
}

struct Result {
  std::vector<double> true_rms, part_rms, map_rms, map_error, saturated;
};

Result print(const Settings& o, const Job& job, planning::TaskPlanner& planner,
             const planning::PlanningSetup& setup, const Scheme& scheme, std::uint64_t seed) {
  const slice::PrintPaths& paths = job.paths;
  plant::IceWorldConfig c = job.world;
  if (o.drift != 0.0) c.line[0].drift = c.line[1].drift = o.drift;
  Lab lab(c, seed);
  const auto law = control::make_surface_controller(scheme.options);
  const auto arm = setup.arm.kinematics;
  const surface::LaserFrame frame{*arm, setup.laser, setup.origin, setup.origin_z_mm, job.laser_latency_s};
  HeightMap action;
  const GridSpec everywhere{160, 160, 1.0, 1.0, -80.0, -80.0};
  const motion::Tool nozzles[2] = {setup.arm.tools[1], setup.arm.tools[2]};
  flow::FlowEstimator flow(flow::FlowOptions{});
  HeightMap before(everywhere, 0.0), last_error;
  Result r;
  const slice::LayerPaths table = job.map_table ? slice::table_layer(paths) : slice::LayerPaths{};
  for (int k = job.map_table ? 0 : 1; k <= o.intervals; ++k) {
    flow::FlowInterval laid{
        0, HeightMap(everywhere), {HeightMap(everywhere, 0.0), HeightMap(everywhere, 0.0)}};
    const int top_layer = job.interval_layers * k;
    for (int n = top_layer - job.interval_layers + 1; k > 0 && n <= top_layer; ++n)
      for (const planning::PathTask& t :
           planning::tasks_of(paths, *slice::find_layer(paths, n), false, setup)) {
        const planning::PlannedTask p = planner.plan(t, action.size() ? &action : nullptr);
        if (!p.problem.empty()) {
          std::fprintf(stderr, "refused: %s\n", p.problem.c_str());
          std::exit(1);
        }
        lab.run(p, t.material, setup.valves[t.material].setting.pulse_s);
        for (const planning::PlannedList& l : p.lists)
          flow::add_laid({p.trajectory, l.start_s, 0.002, kValveLatency_s, l.volume_mm3, l.ticks},
                         {*arm, nozzles[t.material], setup.origin}, laid.nominal_mm[t.material]);
      }
    const slice::LayerPaths& top = k == 0 ? table : *slice::find_layer(paths, top_layer);
    std::vector<surface::SurfacePoint> points;
    for (const planning::PathTask& t : planning::tasks_of(paths, top, true, setup)) {
      const planning::PlannedTask p = planner.plan(t, nullptr);
      surface::add_readings(p.trajectory, frame, job.period_s, lab.measure(p, t.material), points);
    }
    const GridSpec grid = slice::footprint_grid(top, 1.0);
    const Grid<std::uint8_t> material = slice::footprint_materials(top, grid);
    surface::ScatterOptions scatter = job.scatter;
    scatter.smooth = scatter.smooth && o.map != "raw";
    surface::ScatterEstimate map =
        surface::estimate_surface(grid, slice::footprint_mask(material), points, scatter);
    const HeightMap truth = lab.truth(grid);
    if (o.map == "true") {
      map.height = truth;
      surface::fill_from_nearest(map.height);
    }
    const double nominal = top.z * slice::kMmPerUnit;
    HeightMap known = map.height;
    for (std::size_t n = 0; n < known.size(); ++n)
      if (map.quality.cells[n] != 0) known.cells[n] = kNotMeasured;
    known = resample(known, everywhere, kNotMeasured);
    laid.layer = top_layer;
    for (std::size_t n = 0; n < known.size(); ++n) laid.rise_mm.cells[n] = known.cells[n] - before.cells[n];
    before = known;
    if (k > 0) flow.add(laid);
    law->use_flow(flow.estimate().factor);
    if (o.each)
      std::printf("    flow %.3f +- %.3f, %.3f +- %.3f\n", flow.estimate().factor[0],
                  flow.estimate().factor_std[0], flow.estimate().factor[1], flow.estimate().factor_std[1]);
    const control::SurfaceDecision d =
        law->decide({map.height, material, nominal, top_layer, 0, map.noise_std_mm});
    action = d.u;
    if (k == 0) continue;
    double squares = 0.0, off = 0.0, cells = 0.0, part_squares = 0.0, part_cells = 0.0;
    const Mask judged = replay::judged_cells(top, grid);
    for (std::size_t n = 0; n < truth.size(); ++n) {
      if (!judged.cells[n]) continue;
      if (ice_zones::inside_part(material, n)) {
        part_squares += (truth.cells[n] - nominal) * (truth.cells[n] - nominal);
        part_cells += 1.0;
      }
      squares += (truth.cells[n] - nominal) * (truth.cells[n] - nominal);
      cells += 1.0;
      off += (truth.cells[n] - map.height.cells[n]) * (truth.cells[n] - map.height.cells[n]);
    }
    r.true_rms.push_back(std::sqrt(squares / cells));
    r.part_rms.push_back(std::sqrt(part_squares / part_cells));
    r.map_rms.push_back(d.rms_mm);
    r.map_error.push_back(std::sqrt(off / cells));
    r.saturated.push_back(d.saturated_fraction);
    if (o.each)
      std::printf(
          "  seed %llu interval %2d: true rms %.4f, inside the part %.4f, map %.4f, map - truth %.4f, mean "
          "%.4f, saturated %.3f\n",
          static_cast<unsigned long long>(seed), k, r.true_rms.back(), r.part_rms.back(), d.rms_mm,
          r.map_error.back(), d.mean_error_mm, d.saturated_fraction);
    HeightMap error(grid, kNotMeasured);
    for (std::size_t n = 0; n < truth.size(); ++n)
      if (judged.cells[n]) error.cells[n] = truth.cells[n] - nominal;
    if (o.each) ice_zones::tell_slopes(error, last_error, material);
    last_error = error;
    if (!o.picture.empty())
      write_file_atomically(
          o.picture, replay::heat_map(error, {-400.0, 400.0, replay::ColorMap::kDiverging}, "true error"));
    if (o.each) {
      ice_zones::tell_zones(truth, map.height, material, judged, nominal);
      ice_zones::tell_bands(truth, map.height, material, judged, nominal);
    }
  }
  return r;
}

}  // namespace

int main(int argc, char** argv) {
  Settings o;
  for (int n = 1; n < argc; ++n) {
    const std::string name = argv[n];
    if (name == "--each") {
      o.each = true;
      continue;
    }
    if (name == "--staggered") {
      o.staggered = true;
      continue;
    }
    if (name == "--gear") {
      o.gear = true;
      continue;
    }
    const char* value = n + 1 < argc ? argv[++n] : "";
    if (name == "--intervals")
      o.intervals = std::atoi(value);
    else if (name == "--seeds")
      o.seeds = std::atoi(value);
    else if (name == "--first-seed")
      o.first_seed = std::atoi(value);
    else if (name == "--drift")
      o.drift = std::atof(value);
    else if (name == "--experiment")
      o.experiment = value;
    else if (name == "--set")
      o.overrides.push_back(value);
    else if (name == "--map")
      o.map = value;
    else if (name == "--picture")
      o.picture = value;
    else if (name == "--spacing")
      o.spacing_mm = std::atof(value);
    else if (name == "--size")
      o.size = std::atof(value);
    else if (name == "--schemes" || name == "--scheme")
      o.schemes = value;
    else
      return std::fprintf(stderr, "unknown argument %s\n", name.c_str()), 2;
  }
  const Job job = job_of(o);
  std::map<bool, std::pair<planning::PlanningSetup, std::unique_ptr<planning::TaskPlanner>>> planners;
  for (std::size_t at = 0; at < o.schemes.size();) {
    const std::size_t end = std::min(o.schemes.find(',', at), o.schemes.size());
    const std::string name = o.schemes.substr(at, end - at);
    at = end + 1;
    const Scheme scheme =
        name == "own" ? Scheme{job.options, job.options.version == control::SurfaceVersion::kPathSpeed}
                      : scheme_named(name);
    auto& [setup, planner] = planners[scheme.speed];
    if (!planner) {
      setup = job.setup[scheme.speed];
      planner = std::make_unique<planning::TaskPlanner>(setup);
    }
    double mean = 0.0, part = 0.0, last = 0.0, worst = 0.0, map_off = 0.0;
    const double begin = cpu_s();
    for (int seed = o.first_seed; seed < o.first_seed + o.seeds; ++seed) {
      const Result r = print(o, job, *planner, setup, scheme, std::uint64_t(seed));
      double late = 0.0;  // intervals from the fourth on
      for (std::size_t k = 0; k < r.true_rms.size(); ++k) {
        if (k >= 3) late += r.true_rms[k] / double(r.true_rms.size() - 3);
        if (k >= 3) {
          worst = std::max(worst, r.part_rms[k]);
          part += r.part_rms[k] / double(r.true_rms.size() - 3) / o.seeds;
        }
        map_off += r.map_error[k] / double(r.map_error.size()) / o.seeds;
      }
      mean += late / o.seeds;
      last += r.part_rms.back() / o.seeds;
      if (scheme.speed) {
        planner->next_batch();
        planner->next_batch();
      }
    }
    std::printf(
        "%-16s drift %+.2f: true rms from interval 4 on %.4f mm; inside the part %.4f, last %.4f, worst "
        "%.4f; map - truth %.4f mm; %.1f s of CPU a print\n",
        name.c_str(), o.drift, mean, part, last, worst, map_off, (cpu_s() - begin) / o.seeds);
    std::fflush(stdout);
  }
  return 0;
}
