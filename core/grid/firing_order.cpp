#include "core/grid/firing_order.h"

#include <stdexcept>

namespace firn {

std::vector<std::uint32_t> firing_order(const DropletPattern& pattern, int pass) {
  std::vector<std::uint32_t> order;
  const GridSpec& s = pattern.spec;
  for (int j = 0; j < s.ny; ++j)
    for (int n = 0; n < s.nx; ++n) {
      const int i = towards_plus_x(j) ? n : s.nx - 1 - n;
      if (pattern.at(i, j) > pass) order.push_back(std::uint32_t(s.index(i, j)));
    }
  return order;
}

DropletPattern fired_cells(const DropletPattern& pattern, int pass, std::size_t from, std::size_t to) {
  const auto order = firing_order(pattern, pass);
  if (from > to || to > order.size()) throw std::out_of_range("fired_cells: range outside the pass");
  DropletPattern out(pattern.spec);
  for (std::size_t n = from; n < to; ++n) out.cells[order[n]] = 1;
  return out;
}

}  // namespace firn
