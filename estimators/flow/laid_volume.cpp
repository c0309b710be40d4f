#include "estimators/flow/laid_volume.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::flow {

void add_laid(const FiredList& list, const NozzleFrame& frame, HeightMap& nominal) {
  const Trajectory& t = list.motion;
  const int joints = frame.arm.joints();
  if (t.axes < joints || !(t.tick_s > 0.0))
    throw std::invalid_argument("trajectory " + std::to_string(t.id) + " has " + std::to_string(t.axes) +
                                " axes, the arm " + std::to_string(joints));
  const std::size_t samples = t.samples(), n = list.ticks.size();
  if (samples < 2 || n == 0) return;
  motion::Jets q(motion::kMaxJoints, n), flange(motion::kTaskAxes, n), tip(motion::kTaskAxes, n);
  for (std::size_t k = 0; k < n; ++k) {
    const double at = std::clamp((list.start_s + list.ticks[k] * list.tick_s + list.latency_s) / t.tick_s,
                                 0.0, double(samples - 1));
    const std::size_t i = std::min(std::size_t(at), samples - 2);
    for (int a = 0; a < joints; ++a) {
      const double* p = t.positions.data() + i * std::size_t(t.axes) + std::size_t(a);
      q.of(a, 0)[k] = p[0] + (at - double(i)) * (p[t.axes] - p[0]);
      for (int order = 1; order < 4; ++order) q.of(a, order)[k] = 0.0;
    }
  }
  frame.arm.forward(q, flange);
  motion::flange_to_tool(frame.tool, flange, tip);
  const GridSpec& g = nominal.spec;
  const double height_mm = list.volume_mm3 / double(n) / (g.pitch_x_mm * g.pitch_y_mm);
  for (std::size_t k = 0; k < n; ++k) {
    const double i =
        std::floor((tip.of(motion::kX, 0)[k] - frame.origin.x_mm - g.origin_x_mm) / g.pitch_x_mm + 0.5);
    const double j =
        std::floor((tip.of(motion::kY, 0)[k] - frame.origin.y_mm - g.origin_y_mm) / g.pitch_y_mm + 0.5);
    if (i >= 0.0 && j >= 0.0 && i < g.nx && j < g.ny) nominal.at(int(i), int(j)) += height_mm;
  }
}

}  // namespace firn::flow
