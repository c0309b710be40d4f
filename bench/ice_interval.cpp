// CPU time of what happens after a measurement of the ice printer, on a helical gear of 107.6 mm in its scaffold: map from
// laser readings, control law, motions and pulses of the next interval.
//
//   build/bench/ice_interval [INTERVALS [speed|frequency [NOMINAL_MM_S [TOLERANCE_MM]]]]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "bench/ice_gear.h"
#include "core/control/surface/surface_controller.h"
#include "core/grid/random.h"
#include "core/slice/footprint.h"
#include "estimators/surface/path_readings.h"
#include "procs/path_planner/path_planning.h"

namespace {

using namespace firn;

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
  const int intervals = argc > 1 ? std::atoi(argv[1]) : 2;
  const bool speed = argc > 2 && std::string(argv[2]) == "speed";
  const double nominal = argc > 3 ? std::atof(argv[3]) : (speed ? 25.0 : 125.0);
  constexpr int kLayers = ice_gear::kInterval_layers;
  const slice::PrintPaths print = ice_gear::print(intervals);

  planning::PlanningSetup setup;
  setup.machine = parse_machine("[machine]\nname = \"cobra600\"\n", "bench");
  setup.laser = tools(setup.machine)[3];
  setup.origin = {354.0, -46.0};
  setup.origin_z_mm = 20.0;
  setup.speeds = {{{nominal, nominal, 50.0}, {nominal, nominal, 125.0}}};
  setup.valve_limits = valve_limits(setup.machine.valve);
  setup.valves = {{valve_setting(setup.machine.valve), 0.01}, {valve_setting(setup.machine.valve), 0.01}};
  if (argc > 4) setup.tolerance_mm = std::atof(argv[4]);
  setup.version = speed ? control::SurfaceVersion::kPathSpeed : control::SurfaceVersion::kValveFrequency;
  planning::TaskPlanner planner(setup);
  const auto arm = make_arm(setup.machine);

  control::SurfaceOptions options;
  options.version = setup.version;
  const auto smf = control::make_surface_controller(options);
  HeightMap action;
  double all = 0.0;
  for (int k = 1; k <= intervals; ++k) {
    const double begin = cpu_s();
    planner.next_batch();
    double print_s = 0.0, measure_s = 0.0;
    std::size_t paths = 0;
    std::int64_t pulses = 0;
    const double before_motions = cpu_s();
    if (!speed)  // what no action changes is planned ahead
      for (int n = kLayers * (k - 1) + 1; n <= kLayers * k; ++n)
        for (const planning::PathTask& t : planning::tasks_of(print, *slice::find_layer(print, n), false, setup)) planner.prepare(t);
    const double before_deposit = cpu_s();
    for (int n = kLayers * (k - 1) + 1; n <= kLayers * k; ++n)
      for (const planning::PathTask& t : planning::tasks_of(print, *slice::find_layer(print, n), false, setup)) {
        const planning::PlannedTask p = planner.plan(t, action.size() ? &action : nullptr);
        if (!p.problem.empty()) std::printf("refused: %s\n", p.problem.c_str());
        print_s += p.trajectory.certificate.duration_s, ++paths, pulses += p.pulses();
      }
    const double deposit_cpu = cpu_s() - before_deposit;

    const slice::LayerPaths& top = *slice::find_layer(print, kLayers * k);
    const surface::LaserFrame frame{*arm, setup.laser, setup.origin, setup.origin_z_mm, 0.03};
    std::vector<std::pair<planning::PlannedTask, std::vector<float>>> runs;
    RandomStream random(std::uint64_t(k), Purpose::kTest);
    for (const planning::PathTask& t : planning::tasks_of(print, top, true, setup)) {
      planning::PlannedTask p = planner.plan(t, nullptr);
      if (!p.problem.empty()) std::printf("refused: %s\n", p.problem.c_str());
      measure_s += p.trajectory.certificate.duration_s;
      std::vector<float> z;
      for (double at = 0.03; at < p.trajectory.certificate.duration_s; at += 0.01) {
        const Point2 where = p.tool[std::min(std::size_t(at / 0.016), p.tool.size() - 1)];
        z.push_back(float(0.2 * std::sin(0.1 * where.x_mm) * std::cos(0.08 * where.y_mm) + 0.02 * random.normal()));
      }
      runs.emplace_back(std::move(p), std::move(z));
    }
    const double planned = cpu_s();
    const GridSpec grid = slice::footprint_grid(top, 1.0);
    const Grid<std::uint8_t> material = slice::footprint_materials(top, grid);
    std::vector<surface::SurfacePoint> points;
    for (const auto& [p, z] : runs) surface::add_readings(p.trajectory, frame, 0.01, z, points);
    const surface::ScatterEstimate map = surface::estimate_surface(grid, slice::footprint_mask(material), points, {});
    const double mapped = cpu_s();
    const control::SurfaceDecision d = smf->decide({map.height, material, 1.2 * k, kLayers * k, 0, map.noise_std_mm});
    action = d.u;
    const double decided = cpu_s();
    std::printf("interval %d: %zu paths, %lld pulses, print %.0f s, measure %.0f s; CPU: motions ahead %.3f s, motions and pulses after the map %.3f s, measurement paths %.3f s, map %.3f s (%zu readings, %d x %d cells), law %.4f s; covered %.2f, noise %.3f mm, rms %.3f mm\n",
                k, paths, static_cast<long long>(pulses), print_s, measure_s, before_deposit - before_motions, deposit_cpu, planned - before_deposit - deposit_cpu, mapped - planned, points.size(), grid.nx, grid.ny,
                decided - mapped, map.covered_fraction, map.noise_std_mm, d.rms_mm);
    all += cpu_s() - begin;
  }
  std::printf("together %.2f s of CPU, %.2f s per interval\n", all, all / intervals);
  return 0;
}
