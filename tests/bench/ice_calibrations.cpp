// Planted cases through the calibrations of the simulated ice lab: worst error, root mean square, coverage of
// the 95 % intervals.
//   build/bench/ice_calibrations [cases = 100]
//   [laser-offset|laser-latency|level-table|turned-table|valve-latency|flow-curve ...] [--each] [--from FIRST
//   = 1] [-o FOLDER and a study's options]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/bench.h"
#include "tests/bench/case_bench.h"
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
  int count = 100, from = 1;
  bool each = false;
  std::vector<std::string> only, names;
  for (const Kind& kind : kinds()) names.push_back(kind.name);
  CaseBench bench("ice_calibrations", "planted cases through the calibrations of the simulated ice lab");
  bench.options().option("CASES", count, "").show_default().within(1, 1000000);
  bench.options().option("KIND", only, "default: all").one_of(names);
  bench.options().option("--from", from, "first case").show_default().within(1, 1000000000);
  bench.options().flag("--each", each, "each case");
  if (const auto code = bench.parse(argc, argv)) return *code;
  const planted::IceLab lab = planted::shipped_ice_lab(FIRN_SOURCE_DIR);
  std::vector<Kind> wanted = kinds();
  std::erase_if(wanted, [&](const Kind& kind) {
    return !only.empty() && std::find(only.begin(), only.end(), kind.name) == only.end();
  });
  Cases cases{"ice_calibrations", lab.machine_toml, {}, {}, {}};
  for (const Kind& kind : wanted) cases.kinds.push_back(kind.name);
  for (int c = from; c < from + count; ++c) cases.seeds.push_back(std::uint64_t(c));
  cases.make = [&](std::size_t kind, std::uint64_t seed, int) {
    std::vector<double> numbers;
    for (const Judged& j : wanted[kind].judged(lab, seed))
      numbers.insert(numbers.end(), {j.error, j.ci95_half_width});
    return text_of(numbers);
  };
  std::vector<std::string> words{std::to_string(count), "--from", std::to_string(from)};
  words.insert(words.begin() + 1, only.begin(), only.end());
  int code = 0;
  const auto results = bench.results(cases, words, code);
  if (!results) return code;
  std::printf("%-14s %6s %6s %12s %12s %12s %12s %9s %8s\n", "calibration", "cases", "failed", "worst",
              "mean", "rms", "half 95 %", "coverage", "CPU s");
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    double worst = 0.0, sum = 0.0, squares = 0.0, half = 0.0, cpu_s = 0.0;
    long n = 0, inside = 0;
    int failed = 0;
    for (std::size_t c = 0; c < cases.seeds.size(); ++c) {
      const CaseBench::Result& r = (*results)[k * cases.seeds.size() + c];
      cpu_s += r.cpu_s;
      if (!r.made) {
        ++failed;
        std::printf("  %4d %s\n", int(cases.seeds[c]), r.reason.c_str());
        continue;
      }
      const std::vector<double> numbers = numbers_of(r.text);
      for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
        const Judged j{numbers[i], numbers[i + 1]};
        if (each)
          std::printf("  %4d error %12.6f +- %10.6f%s\n", int(cases.seeds[c]), j.error, j.ci95_half_width,
                      j.inside() ? "" : "  outside");
        worst = std::max(worst, std::abs(j.error));
        sum += j.error;
        squares += j.error * j.error;
        half += j.ci95_half_width;
        ++n;
        inside += j.inside();
      }
    }
    const double many = double(std::max(n, 1L));
    std::printf("%-14s %6d %6d %12.6f %12.6f %12.6f %12.6f %8.1f%% %8.1f   %s, wanted %g\n",
                wanted[k].name.c_str(), count, failed, worst, sum / many, std::sqrt(squares / many),
                half / many, 100.0 * double(inside) / many, cpu_s, wanted[k].unit.c_str(),
                wanted[k].tolerance);
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}

}  // namespace firn::bench::ice_calibrations
