// Measures how arm, valves and laser keep together in a print of a block by the V+ text and the valves'
// binary in simavr, for clocks that drift apart.
//
//   build/bench/trigger_chain [ROBOT_PPM VALVES_PPM LASER_PPM]     one print; default: three, a minute each
#include <catch2/catch.hpp>  // of tests/print/ice_runs.h

#include <cstdio>
#include <cstdlib>

#include "core/options/number.h"
#include "tests/firmware/program_print.h"
#include "tests/firmware/trigger_chain.h"

namespace {

using namespace firn;
using namespace firn::test;

struct Clocks {
  double robot_ppm, valves_ppm, laser_ppm;
};

bool measure(const Clocks& clocks) {
  IceRun run(block_print(Instruments::kPrograms));
  plant::WorldConfig world;
  run.nature = [&](plant::WorldConfig& c) {
    c.ice.arm.clock_ppm = clocks.robot_ppm;
    for (plant::IceValveParams& v : c.ice.valve) v.clock_ppm = clocks.valves_ppm;
    c.ice.laser.clock_ppm = clocks.laser_ppm;
    with_binaries(c);
    world = c;
  };
  const LabRunReport report = run.go();
  std::printf("robot %+.0f, valves %+.0f, laser %+.0f ppm: %s, %.0f s of the lab's time\n", clocks.robot_ppm,
              clocks.valves_ppm, clocks.laser_ppm, report.result.outcome.c_str(), report.node_seconds);
  if (report.result.status != 0) {
    std::printf("%s\n%s", report.result.reason.c_str(), run.faults().c_str());
    return false;
  }
  constexpr double kLongest_s = 131.072;  // of a list of 65,536 ticks of 2 ms
  std::printf("%-12s %5s %9s %16s %17s %14s %20s\n", "", "paths", "longest s", "constant part ms",
              "off it at most ms", "apart, ppm", "apart in 131 s, ms");
  for (const ChainPart& part : trigger_chain(run.path(), world.ice.arm, world.ice.laser)) {
    double longest_s = 0.0;
    for (const ChainPath& p : part.paths) longest_s = std::max(longest_s, p.span_s);
    std::printf("%-12s %5zu %9.1f %16.2f %17.2f %14.0f %20.1f\n", part.name.c_str(), part.paths.size(),
                longest_s, part.mean_ms, part.worst_ms, part.drift_ppm, part.drift_ppm * 1e-3 * kLongest_s);
  }
  std::fflush(stdout);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr double kMost_ppm = 1000.0;
  if (argc == 4) {
    std::optional<double> ppm[3];
    for (int n = 0; n < 3; ++n) ppm[n] = firn::whole_number<double>(argv[n + 1], -kMost_ppm, kMost_ppm);
    if (ppm[0] && ppm[1] && ppm[2]) return measure({*ppm[0], *ppm[1], *ppm[2]}) ? 0 : 1;
  } else if (argc == 1) {
    bool good = true;
    for (const Clocks& c : {Clocks{20, -18, 5}, Clocks{100, -100, -100}, Clocks{-100, 100, 100}})
      good = measure(c) && good;
    return good ? 0 : 1;
  }
  std::fprintf(stderr, "usage: trigger_chain [ROBOT_PPM VALVES_PPM LASER_PPM], each -1000 to 1000\n");
  return 2;
}
