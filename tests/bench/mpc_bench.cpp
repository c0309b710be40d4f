// Measures quality and speed of layer decisions (docs/measurements.md): processor seconds of this thread,
// medians of five.
//
// - `mpc_bench recovery`: printed layers found again, by spread of the droplets, 20 x 20 and 200 x 200
// - `mpc_bench layers`: the six instances: objective above the best known after so much time, and the proved
// gap
// - `mpc_bench gap FILE.svg [FILE.csv]`: the gap between layer and bound closing
// - `mpc_bench best FOLDER [sweeps]`: writes instances, best layers and table of tests/bench/instances from a
// long run
// - `mpc_bench large [threads]`: 1000 x 1000 and 4000 x 4000 cells, with the most memory the process had
// - `mpc_bench forward`: the height-change model and the gain of every droplet
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "tests/bench/mpc_tables.h"

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const std::string folder = FIRN_SOURCE_DIR "/tests/bench/instances";
  try {
    using namespace firn::bench;
    if (what == "recovery") return print_recovery();
    if (what == "layers") return print_layers(folder);
    if (what == "gap" && argc > 2) return draw_gap(folder, argv[2], argc > 3 ? argv[3] : "");
    if (what == "best" && argc > 2) return search_best(argv[2], argc > 3 ? std::atoi(argv[3]) : 100);
    if (what == "large") return print_large(argc > 2 ? std::atoi(argv[2]) : 1);
    if (what == "forward") return print_forward();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mpc_bench: %s\n", e.what());
    return 1;
  }
  std::fputs(
      "usage: mpc_bench recovery | layers | gap FILE.svg [FILE.csv] | best FOLDER [sweeps] | large [threads] "
      "| forward\n",
      stderr);
  return 2;
}
