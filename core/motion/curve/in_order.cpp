#include "core/motion/curve/in_order.h"

#include <algorithm>

namespace firn::motion {

void put_in_order(std::vector<double>& values) {
  if (std::is_sorted(values.begin(), values.end())) return;
  std::vector<double> smallest(values);  // from each on
  for (std::size_t i = values.size() - 1; i > 0; --i)
    smallest[i - 1] = std::min(smallest[i - 1], smallest[i]);
  double largest = values.front();
  for (std::size_t i = 0; i < values.size(); ++i) {
    largest = std::max(largest, values[i]);
    values[i] = 0.5 * (largest + smallest[i]);
  }
}

}  // namespace firn::motion
