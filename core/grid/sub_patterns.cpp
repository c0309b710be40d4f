#include "core/grid/sub_patterns.h"

#include <algorithm>
#include <cmath>

namespace firn {

int sub_pattern_of(int i, int j, int count) {
  if (count == 2) return (i + j) & 1;
  if (count != 4) return 0;
  static constexpr int kNumber[2][2] = {{0, 3}, {2, 1}};
  return kNumber[i & 1][j & 1];
}

double least_distance_mm(const GridSpec& g, int count) {
  const double x = g.pitch_x_mm, y = g.pitch_y_mm;
  if (count == 1) return std::min(x, y);
  const double two_on = 2.0 * std::min(x, y);
  return count == 2 ? std::min(std::sqrt(x * x + y * y), two_on) : two_on;
}

}  // namespace firn
