#include "tests/plant/bench_lines.h"

#include <cmath>

namespace firn::plant {

void print_layer(Bench& b, int columns, int rows) {
  const GridSpec& g = b.world.config().grid;
  const auto counts = [](double mm) { return std::llround(mm * 1e4); };
  b.stage("PSOCONTROL @0 RESET");
  b.stage("PSOOUTPUT @0 PULSE");
  arm_jet(b);
  for (int j = 0; j < rows; ++j) {
    const int first = j % 2 == 0 ? 0 : columns - 1, last = columns - 1 - first, step = j % 2 == 0 ? 1 : -1;
    const double start = std::round((g.x_mm(first) - 3.0 * step) * 1e4) / 1e4,
                 end = g.x_mm(last) + 3.0 * step;
    go(b, "LINEAR @0 " + std::to_string(start) + " @1 " + std::to_string(g.y_mm(j)) + " F150");
    std::int64_t at = counts(start);
    for (int n = 0; n < columns; ++n) {
      const std::int64_t next = counts(g.x_mm(first + n * step));
      b.stage("IGLOBAL(" + std::to_string(50 + n) + ")=" + std::to_string(std::llabs(next - at)));
      at = next;
    }
    b.stage("PSOARRAY @0,50," + std::to_string(columns));
    b.stage("PSODISTANCE @0 ARRAY");
    b.stage("PSOCONTROL @0 ARM");
    go(b, "LINEAR @0 " + std::to_string(end) + " F150");
    b.stage("PSOCONTROL @0 OFF");
  }
  disarm_jet(b);
  b.ask(kLampPort, "CONN18\r");
  b.ask(kLampPort, "OPN40\r");
  b.run(500'000);
  b.ask(kLampPort, "CLS3A\r");
}

}  // namespace firn::plant
