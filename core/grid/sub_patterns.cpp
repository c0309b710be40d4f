#include "core/grid/sub_patterns.h"

namespace firn {

int sub_pattern_of(int i, int j, int count) {
  if (count == 2) return (i + j) & 1;
  if (count != 4) return 0;
  static constexpr int kNumber[2][2] = {{0, 3}, {2, 1}};
  return kNumber[i & 1][j & 1];
}

}  // namespace firn
