// Measures CPU and wall time of the steps that follow a measurement of the ice printer, on a helical gear of
// 107.6 mm in its scaffold: map from laser readings, control law, motions and pulses of the next interval.
//
//   build/bench/ice_interval [INTERVALS [speed|frequency [NOMINAL_MM_S [TOLERANCE_MM]]]]
//   Any of them: --threads N for the motions and pulses (default 1).
//   build/bench/ice_interval INTERVALS --experiment experiments/ice-helical-gear.toml [KEY=VALUE...]     #
//   the output of the slicer
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "config/ice_lab.h"
#include "config/include.h"
#include "core/control/surface/surface_controller.h"
#include "core/grid/random.h"
#include "core/planning/path_planning.h"
#include "core/slice/coverage/footprint.h"
#include "estimators/surface/path_readings.h"
#include "print/inputs/ice_inputs.h"
#include "runtime/thread_pool.h"
#include "tests/bench/bench.h"
#include "tests/bench/ice_gear.h"

namespace firn::bench::ice_interval {

namespace {

using namespace firn;

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}
double cpu_s() { return seconds(CLOCK_PROCESS_CPUTIME_ID); }
double wall_s() { return seconds(CLOCK_MONOTONIC); }

struct Job {
  slice::PrintPaths paths;
  int layers = ice_gear::kInterval_layers;
  planning::PlanningSetup setup;
  control::SurfaceOptions law;
  surface::ScatterOptions scatter;
  double latency_s = 0.03, pitch_mm = 1.0;
  bool motions_keep = false;
};

Job gear_job(int intervals, int argc, char** argv) {
  const bool speed = argc > 2 && std::string(argv[2]) == "speed";
  const double nominal = argc > 3 ? std::atof(argv[3]) : (speed ? 25.0 : 125.0);
  Job j;
  j.paths = ice_gear::print(intervals);
  const Machine machine = parse_machine("[machine]\nname = \"cobra600\"\n", "bench");
  j.setup.arm = planning_arm(machine);
  j.setup.laser = j.setup.arm.tools[3];
  j.setup.origin = {354.0, -46.0};
  j.setup.origin_z_mm = 20.0;
  j.setup.speeds = {{{nominal, nominal, 50.0}, {nominal, nominal, 125.0}}};
  j.setup.valve_limits = valve_limits(machine.valve);
  j.setup.valves = {{valve_setting(machine.valve), 0.01}, {valve_setting(machine.valve), 0.01}};
  if (argc > 4) j.setup.tolerance_mm = std::atof(argv[4]);
  j.setup.version = speed ? control::SurfaceVersion::kPathSpeed : control::SurfaceVersion::kValveFrequency;
  j.law.version = j.setup.version;
  j.motions_keep = !speed;
  return j;
}

Job experiment_job(int intervals, const std::string& file, const std::vector<std::string>& overrides) {
  Experiment e = load_experiment(file, overrides);
  e.ice.height_mm = intervals * e.ice.interval_layers * e.ice.layer_height_mm;
  const Blobs inputs = make_ice_inputs(e, std::filesystem::path(file).parent_path());
  const std::vector<std::byte>& text = blob(inputs, "machine").bytes;
  Job j;
  j.paths = slice::decode_print_paths(blob(inputs, "paths").bytes);
  j.layers = e.ice.interval_layers;
  j.setup =
      planning_setup(e, parse_machine({reinterpret_cast<const char*>(text.data()), text.size()}, "machine"));
  j.law = surface_options(e, 0);
  j.scatter = {e.ice.measure_spacing_mm, e.control.smoothing > 0.0, e.ice.map_samples};
  j.latency_s = e.laser_point.latency_s;
  j.pitch_mm = e.ice.pitch_mm;
  j.motions_keep = j.law.version == control::SurfaceVersion::kValveFrequency;
  return j;
}

}  // namespace

FIRN_BENCH(ice_interval) {
  int threads = 1;
  for (int n = 1; n + 1 < argc; ++n)
    if (std::string(argv[n]) == "--threads") {
      threads = std::atoi(argv[n + 1]);
      std::rotate(argv + n, argv + n + 2, argv + argc);
      argc -= 2;
    }
  const ParallelFor parallel = parallel_on(threads);
  const int intervals = argc > 1 ? std::atoi(argv[1]) : 2;
  const bool named = argc > 3 && std::string(argv[2]) == "--experiment";
  const Job job =
      named ? experiment_job(intervals, argv[3], {argv + 4, argv + argc}) : gear_job(intervals, argc, argv);
  const slice::PrintPaths& print = job.paths;
  const int layers = job.layers;
  planning::TaskPlanner planner(job.setup);
  const auto arm = job.setup.arm.kinematics;

  const auto smf = control::make_surface_controller(job.law);
  HeightMap action;
  double all = 0.0;
  double last_map_s = 0.0, last_map_wall_s = 0.0;
  std::vector<double> updates, walls;  // from a map's last reading to the last pulse that follows
  for (int k = 1; k <= intervals; ++k) {
    const double begin = cpu_s();
    planner.next_batch();
    double print_s = 0.0, measure_s = 0.0;
    std::size_t paths = 0;
    std::int64_t pulses = 0;
    const double before_motions = cpu_s();
    if (job.motions_keep)  // motions that no action changes are planned ahead
      for (int n = layers * (k - 1) + 1; n <= layers * k; ++n)
        planner.prepare(planning::tasks_of(print, *slice::find_layer(print, n), false, job.setup), parallel);
    const double before_deposit = cpu_s(), before_deposit_wall = wall_s();
    std::vector<planning::PathTask> tasks;
    for (int n = layers * (k - 1) + 1; n <= layers * k; ++n)
      for (planning::PathTask& t : planning::tasks_of(print, *slice::find_layer(print, n), false, job.setup))
        tasks.push_back(std::move(t));
    const double tasks_cpu = cpu_s() - before_deposit;
    for (const planning::PlannedTask& p : planner.plan(tasks, action.size() ? &action : nullptr, parallel)) {
      if (!p.problem.empty()) std::printf("refused: %s\n", p.problem.c_str());
      print_s += p.trajectory.certificate.duration_s;
      ++paths;
      pulses += p.pulses();
    }
    const double deposit_cpu = cpu_s() - before_deposit, deposit_wall = wall_s() - before_deposit_wall;

    const slice::LayerPaths& top = *slice::find_layer(print, layers * k);
    const surface::LaserFrame frame{*arm, job.setup.laser, job.setup.origin, job.setup.origin_z_mm,
                                    job.latency_s};
    std::vector<std::pair<planning::PlannedTask, std::vector<float>>> runs;
    RandomStream random(std::uint64_t(k), Purpose::kTest);
    for (const planning::PathTask& t : planning::tasks_of(print, top, true, job.setup)) {
      planning::PlannedTask p = planner.plan(t, nullptr);
      if (!p.problem.empty()) std::printf("refused: %s\n", p.problem.c_str());
      measure_s += p.trajectory.certificate.duration_s;
      std::vector<float> z;
      for (double at = job.latency_s; at < p.trajectory.certificate.duration_s; at += 0.01) {
        const Point2 where = p.tool[std::min(std::size_t(std::max(0.0, at) / 0.016), p.tool.size() - 1)];
        z.push_back(
            float(0.2 * std::sin(0.1 * where.x_mm) * std::cos(0.08 * where.y_mm) + 0.02 * random.normal()));
      }
      runs.emplace_back(std::move(p), std::move(z));
    }
    const double planned = cpu_s(), planned_wall = wall_s();
    const GridSpec grid = slice::footprint_grid(top, job.pitch_mm);
    const Grid<std::uint8_t> material = slice::footprint_materials(top, grid);
    std::vector<surface::SurfacePoint> points;
    for (const auto& [p, z] : runs) surface::add_readings(p.trajectory, frame, 0.01, z, points);
    const surface::ScatterEstimate map =
        surface::estimate_surface(grid, slice::footprint_mask(material), points, job.scatter);
    const double mapped = cpu_s();
    const control::SurfaceDecision d =
        smf->decide({map.height, material, job.law.interval_mm * k, layers * k, 0, map.noise_std_mm});
    action = d.u;
    const double decided = cpu_s(), decided_wall = wall_s();
    std::printf(
        "interval %d: %zu paths, %lld pulses, print %.0f s, measure %.0f s; CPU: motions ahead %.3f s, "
        "motions and pulses after the map %.3f s, measurement paths %.3f s, map %.3f s (%zu readings, %d x "
        "%d cells), law %.4f s; covered %.2f, noise %.3f mm, rms %.3f mm\n",
        k, paths, static_cast<long long>(pulses), print_s, measure_s, before_deposit - before_motions,
        deposit_cpu, planned - before_deposit - deposit_cpu, mapped - planned, points.size(), grid.nx,
        grid.ny, decided - mapped, map.covered_fraction, map.noise_std_mm, d.rms_mm);
    std::printf("  of them tasks %.3f s\n", tasks_cpu);
    if (k > 1) {
      updates.push_back(deposit_cpu + last_map_s);
      walls.push_back(deposit_wall + last_map_wall_s);
    }
    last_map_s = decided - planned;
    last_map_wall_s = decided_wall - planned_wall;
    all += cpu_s() - begin;
  }
  std::printf("together %.2f s of CPU, %.2f s per interval\n", all, all / intervals);
  if (updates.empty()) return 0;
  std::sort(updates.begin(), updates.end());
  std::sort(walls.begin(), walls.end());
  std::printf(
      "update (map, law, motions and pulses of what follows): median %.3f s of CPU, largest %.3f s, of %zu; "
      "by the clock %.3f, %.3f s, %d threads\n",
      updates[updates.size() / 2], updates.back(), updates.size(), walls[walls.size() / 2], walls.back(),
      threads);
  return 0;
}

}  // namespace firn::bench::ice_interval
