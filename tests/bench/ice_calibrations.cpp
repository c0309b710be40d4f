// Planted cases through the calibrations of the simulated ice lab: worst error, root mean square, coverage of
// the 95 % intervals.
//   build/bench/ice_calibrations [cases = 100]
//   [laser-offset|laser-latency|level-table|turned-table|valve-latency|flow-curve ...] [--each] [--from FIRST
//   = 1]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/bench.h"
#include "tests/support/planted_ice.h"

namespace firn::bench::ice_calibrations {

using namespace firn;
using planted::Judged;

namespace {

constexpr double kGap_mm = 2.0;  // of the marks of valve-latency

struct Kind {
  std::string name, unit;
  double tolerance;
  std::function<std::vector<Judged>(const planted::IceLab&, std::uint64_t)> judged;
};

std::vector<Kind> kinds() {
  const auto plain = [](auto run, auto judge, bool place_known, bool table = false) {
    return [=](const planted::IceLab& lab, std::uint64_t n) {
      Experiment e = planted::plant_case(lab, n);
      if (!table) e.plant.ice.foot_mm.assign(4, e.plant.ice.foot_mm[0] * 0.1);
      if (place_known) {
        e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
        e.laser_point.latency_s = planted::laser_latency_s(e);
      }
      LabCalibrationOptions o;
      o.seed = n;
      return judge(e, run(e, lab.machine_toml, o));
    };
  };
  return {
      {"laser-offset", "mm", 0.2, plain(calibrate_laser_offset, planted::judge_offset, false)},
      {"laser-latency", "s", 0.002, plain(calibrate_laser_latency, planted::judge_laser_latency, false)},
      {"level-table", "mm", 0.05, plain(calibrate_table, planted::judge_table, true, true)},
      {"turned-table", "mm", 0.1,
       [](const planted::IceLab& lab, std::uint64_t n) {  // as told, from screws up to 0.5 mm off
         Experiment e = planted::plant_case(lab, n);
         planted::plant_screws(e, n);
         e.plant.ice.laser_dx_mm = e.plant.ice.laser_dy_mm = 0.0;
         LabCalibrationOptions o;
         o.rounds = 10;
         return planted::judge_table(e, calibrate_table(e, lab.machine_toml, o));
       }},
      {"valve-latency", "s", 0.002,
       plain(
           calibrate_valve_latency,
           [](const Experiment& e, const LabCalibration& c) {
             return planted::judge_valve_latency(e, c, 0, kGap_mm);
           },
           true)},
      {"flow-curve", "", 0.02,
       plain(
           calibrate_flow_curve,
           [](const Experiment& e, const LabCalibration& c) { return planted::judge_flow(e, c, 0); }, true)}};
}

}  // namespace

FIRN_BENCH(ice_calibrations) try {
  int cases = 100, from = 1;
  bool each = false;
  std::vector<std::string> only, names;
  for (const Kind& kind : kinds()) names.push_back(kind.name);
  CLI::App app("planted cases through the calibrations of the simulated ice lab");
  app.add_option("CASES", cases)->capture_default_str()->check(CLI::Range(1, 1000000));
  app.add_option("KIND", only, "default: all")->check(CLI::IsMember(names));
  app.add_option("--from", from, "first case")->capture_default_str()->check(CLI::Range(1, 1000000000));
  app.add_flag("--each", each, "each case");
  CLI11_PARSE(app, argc, argv);
  const planted::IceLab lab = planted::shipped_ice_lab(FIRN_SOURCE_DIR);
  std::printf("%-14s %6s %6s %12s %12s %12s %12s %9s %8s\n", "calibration", "cases", "failed", "worst",
              "mean", "rms", "half 95 %", "coverage", "CPU s");
  for (const Kind& kind : kinds()) {
    if (!only.empty() && std::find(only.begin(), only.end(), kind.name) == only.end()) continue;
    const std::clock_t began = std::clock();
    double worst = 0.0, sum = 0.0, squares = 0.0, half = 0.0;
    long n = 0, inside = 0;
    int failed = 0;
    for (int c = from; c < from + cases; ++c) {
      try {
        for (const Judged& j : kind.judged(lab, std::uint64_t(c))) {
          if (each)
            std::printf("  %4d error %12.6f +- %10.6f%s\n", c, j.error, j.ci95_half_width,
                        j.inside() ? "" : "  outside");
          worst = std::max(worst, std::abs(j.error));
          sum += j.error;
          squares += j.error * j.error;
          half += j.ci95_half_width;
          ++n;
          inside += j.inside();
        }
      } catch (const std::exception& e) {
        ++failed;
        std::printf("  %4d %s\n", c, e.what());
      }
    }
    std::printf("%-14s %6d %6d %12.6f %12.6f %12.6f %12.6f %8.1f%% %8.1f   %s, wanted %g\n",
                kind.name.c_str(), cases, failed, worst, sum / double(std::max(n, 1L)),
                std::sqrt(squares / double(std::max(n, 1L))), half / double(std::max(n, 1L)),
                100.0 * double(inside) / double(std::max(n, 1L)),
                double(std::clock() - began) / CLOCKS_PER_SEC, kind.unit.c_str(), kind.tolerance);
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}

}  // namespace firn::bench::ice_calibrations
