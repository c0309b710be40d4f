// Measures cost and error of the ice plant without any feedback: a disc of ice (107.6 mm) in a ring of
// scaffold, printed open loop with a calibrated flow curve.
//   ice_plant_bench [--intervals N] [--seed S] [--drift D] [--fill W] [--quiet]
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>

#include "tests/bench/bench.h"
#include "tests/support/ice_paths.h"

namespace firn::bench::ice_plant_bench {

namespace {

using namespace firn;
using namespace firn::plant;

double user_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

struct Errors {
  double mean = 0.0, rms = 0.0, edge = 0.0, worst = 0.0, worst_at = 0.0;
};

// Against the nominal height, on 1 mm cells; edge = mean of the outermost 2 mm.
Errors errors_of(const Bed& bed, double nominal_mm, double radius_mm) {
  const int n = 2 * int(radius_mm) + 3;
  const HeightMap map = bed.mean_over({n, n, 1.0, 1.0, -0.5 * (n - 1), -0.5 * (n - 1)});
  Errors e;
  double count = 0.0, edge_count = 0.0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double r = std::hypot(map.spec.x_mm(i), map.spec.y_mm(j));
      if (r > radius_mm || r < 4.0) continue;  // rings do not fill their own centre well
      const double d = map.at(i, j) - nominal_mm;
      e.mean += d;
      e.rms += d * d;
      count += 1.0;
      if (std::abs(d) > e.worst) {
        e.worst = std::abs(d);
        e.worst_at = r;
      }
      if (r > radius_mm - 2.0) {
        e.edge += d;
        edge_count += 1.0;
      }
    }
  e.mean /= count;
  e.rms = std::sqrt(e.rms / count);
  e.edge /= edge_count;
  return e;
}

}  // namespace

FIRN_BENCH(ice_plant_bench) {
  int intervals = 1;
  std::uint64_t seed = 1;
  double fill_mm = 3.0;
  IceWorldConfig c;
  bool quiet = false;
  for (int n = 1; n < argc; ++n) {
    const std::string name = argv[n];
    const double value = n + 1 < argc ? std::atof(argv[n + 1]) : 0.0;
    if (name == "--intervals") {
      intervals = int(value);
      ++n;
    } else if (name == "--seed") {
      seed = std::uint64_t(value);
      ++n;
    } else if (name == "--drift") {
      c.line[0].drift = c.line[1].drift = value;
      ++n;
    } else if (name == "--roughness") {
      c.disturbance.roughness = value;
      ++n;
    } else if (name == "--grain") {
      c.disturbance.roughness_mm = value;
      ++n;
    } else if (name == "--fill") {
      fill_mm = value;
      ++n;
    } else if (name == "--quiet")
      quiet = true;
    else
      return std::fprintf(stderr, "unknown argument %s\n", argv[n]), 2;
  }
  if (quiet) {
    c.disturbance.roughness = c.disturbance.pattern = c.disturbance.debris_per_h = c.table.roughness_mm = 0.0;
    for (auto& line : c.line) line.pulsation = 0.0;
    for (auto& bead : c.bead) bead.wander_rad = bead.scatter_mm = 0.0;
  }
  constexpr double kRadius_mm = 53.8, kScaffold_mm = 6.3, kLayer_mm = 0.24;
  IceNature nature(c, seed);
  const auto curve = [&](int valve) {  // as weighed on the bench: cold coil, no drift; one value per 5 Hz
    const Line line(c.line[std::size_t(valve)], seed, valve);
    std::vector<double> table;
    for (double hz = 0.5; hz < 800.0; hz += 5.0) table.push_back(line.steady_pulse_mm3(hz, 0.00125));
    return [table](double hz) { return table[std::min(table.size() - 1, std::size_t(hz / 5.0))]; };
  };
  const auto curve_a = curve(0), curve_b = curve(1);
  const double begin_s = user_s();
  std::int64_t t_us = 1'000'000, pulses = 0;
  std::printf(
      "interval height_mm mean_mm rms_mm edge_mm worst_mm at_r  ice_rms_mm coil_w coil_s  pulses hours "
      "cpu_s\n");
  for (int layer = 1; layer <= 5 * intervals; ++layer) {
    const double z_mm = layer * kLayer_mm + 3.0;
    const auto deposit = [&](int valve, double radius, double width, double speed) {
      const IceTool& tool = valve == 0 ? c.arm.valve_a : c.arm.valve_b;
      const auto line = ice_paths::ring(radius, 37.0 * layer + 90.0 * radius);
      auto run = ice_paths::along(c.arm, tool, line, z_mm, speed, width, valve == 0 ? curve_a : curve_b,
                                  ice_paths::calibrated_late_s(c, valve));
      pulses += std::int64_t(run.ticks.size());
      t_us = ice_paths::print(nature, c, std::move(run), valve, t_us) + 3'000'000;
    };
    for (double r = kRadius_mm + 0.75; r < kRadius_mm + kScaffold_mm; r += 1.5) deposit(1, r, 1.5, 60.0);
    deposit(0, kRadius_mm - 0.75, 1.5, 60.0);
    double r = kRadius_mm - 1.5 - 0.5 * fill_mm;
    for (; r > 0.5 * fill_mm; r -= fill_mm) deposit(0, r, fill_mm, 80.0);
    if (r + 0.5 * fill_mm > 0.6)
      deposit(0, std::max(0.5, 0.5 * (r + 0.5 * fill_mm)), (r + 0.5 * fill_mm), 20.0);
    if (layer % 5 != 0) continue;
    t_us += 600'000'000;  // measured
    nature.catch_up(t_us);
    const Errors all = errors_of(nature.bed(), layer * kLayer_mm, kRadius_mm + kScaffold_mm - 1.0);
    const Errors ice = errors_of(nature.bed(), layer * kLayer_mm, kRadius_mm - 1.0);
    std::printf("%8d %9.2f %7.3f %6.3f %7.3f %8.3f %5.1f %8.3f %6.3f %6.3f %7ld %5.2f %5.2f\n", layer / 5,
                layer * kLayer_mm, all.mean, all.rms, all.edge, all.worst, all.worst_at, ice.rms,
                nature.heat().state().coil[0], nature.heat().state().coil[1], long(pulses),
                double(t_us) * 1e-6 / 3600.0, user_s() - begin_s);
  }
  std::printf("mean height beyond nominal by radius:");
  for (double radius = 4.0; radius < kRadius_mm + kScaffold_mm + 2.0; radius += radius < 46.0 ? 6.0 : 0.5) {
    double sum = 0.0;
    for (int k = 0; k < 720; ++k)
      sum += nature.bed().height_mm(radius * std::cos(k * std::numbers::pi / 360.0),
                                    radius * std::sin(k * std::numbers::pi / 360.0));
    std::printf(" %.1f:%.2f", radius, sum / 720.0 - 5 * intervals * kLayer_mm);
  }
  std::puts("");
  const IceLedger& l = nature.bed().ledger();
  std::printf(
      "landed %.1f + %.1f mm3, lost %.2f, grown %.1f, debris %.1f, on the field %.1f; switchings %u\n",
      l.landed[0], l.landed[1], l.lost, l.grown, l.debris, nature.bed().volume_mm3(),
      nature.heat().switchings());
  return 0;
}

}  // namespace firn::bench::ice_plant_bench
