// Runs calibrations of the ice lab with its instruments behind serial lines and a TCP port, by the clock, and
// in simulated time, and shows the values of both. Exit code 1: one is refused, or they differ by more than
// their 95 % intervals.
//   ./firn bench calibrate_lines [KIND] [OPTION of firn calibrate…]     default: flow-curve, half an hour
#include <algorithm>
#include <cstdio>

#include "files/json.h"
#include "tests/bench/bench.h"
#include "tests/cli/lined_lab.h"

namespace firn::bench::calibrate_lines {

using namespace firn;

FIRN_BENCH(calibrate_lines) {
  const std::string what = argc > 1 ? argv[1] : "flow-curve";
  const std::vector<std::string> more(argv + std::min(argc, 2), argv + argc);
  test::LinedLab lab({}, -60.0, -60.0, 10.0, 10.0);
  const test::Said simulated = lab.calibrate(what, false, more), real = lab.calibrate(what, true, more);
  for (const auto& [name, said] : {std::pair{"simulated", &simulated}, std::pair{"ports", &real}})
    if (said->code != 0) std::printf("%s: %s%s\n", name, said->out.c_str(), said->err.c_str());
  if (simulated.code != 0 || real.code != 0) return 1;
  const auto on_ports = nlohmann::json::parse(real.out), in_time = nlohmann::json::parse(simulated.out);
  bool alike = true;
  for (const test::FoundTwice& f : test::found_twice(real.out, simulated.out)) {
    if (f.half_95 == 0.0 && f.alike()) continue;  // a frequency that was asked for
    std::printf("%-26s %12.5f on ports %12.5f simulated +- %.5f%s\n", f.key.c_str(), f.real, f.simulated,
                f.half_95, f.alike() ? "" : "  DIFFERS");
    alike = alike && f.alike();
  }
  std::printf("%d and %d data, %.0f and %.0f s of the lab's time\n", on_ports["data"].get<int>(),
              in_time["data"].get<int>(), on_ports["lab_s"].get<double>(), in_time["lab_s"].get<double>());
  return alike ? 0 : 1;
}

}  // namespace firn::bench::calibrate_lines
