#include "core/grid/firing_order.h"

#include <algorithm>
#include <limits>

namespace firn {
namespace {

// The cells of one row and sub-row, in order of x.
std::vector<std::uint32_t> cells_of(const DropletPattern& pattern, int pass, const Placement& placement,
                                    int j, int sub_row) {
  std::vector<std::uint32_t> cells;
  for (int i = 0; i < pattern.spec.nx; ++i) {
    const auto c = std::uint32_t(pattern.spec.index(i, j));
    if (pattern.cells[c] > pass && placement.table.sub_row(placement.map.of(c)) == sub_row)
      cells.push_back(c);
  }
  return cells;
}

// The droplets that keep apart from the one before; the others, each between two of these, stay in `cells`.
std::vector<std::uint32_t> apart(std::vector<std::uint32_t>& cells, const GridSpec& grid,
                                 const Placement& placement) {
  std::vector<std::uint32_t> first, second;
  double last_mm = -std::numeric_limits<double>::infinity();
  for (const std::uint32_t c : cells) {
    const double x_mm = (double(c % std::uint32_t(grid.nx)) + placement.of(c).x) * grid.pitch_x_mm;
    const bool far = x_mm - last_mm >= placement.apart_mm;
    (far ? first : second).push_back(c);
    if (far) last_mm = x_mm;
  }
  cells = std::move(second);
  return first;
}

}  // namespace

std::vector<FiringRun> firing_runs(const DropletPattern& pattern, int pass, const Placement& placement) {
  std::vector<FiringRun> runs;
  const bool placed = !placement.map.cells.empty();
  bool towards_plus = true;
  for (int j = 0; j < pattern.spec.ny; ++j) {
    if (!placed) towards_plus = towards_plus_x(j);
    const int sub_rows = placed ? placement.table.sub_rows() : 1;
    for (int s = 0; s < sub_rows; ++s) {
      std::vector<std::uint32_t> cells =
          cells_of(pattern, pass, placement, j, placed ? s : placement.table.sub_row(0));
      while (!cells.empty()) {
        FiringRun run;
        run.row = j;
        run.y = placement.of(cells.front()).y;
        run.towards_plus_x = towards_plus;
        run.cells = apart(cells, pattern.spec, placement);
        if (!towards_plus) std::ranges::reverse(run.cells);
        runs.push_back(std::move(run));
        towards_plus = !towards_plus;
      }
    }
  }
  return runs;
}

std::vector<std::uint32_t> firing_order(const DropletPattern& pattern, int pass, const Placement& placement) {
  std::vector<std::uint32_t> order;
  for (const FiringRun& run : firing_runs(pattern, pass, placement))
    order.insert(order.end(), run.cells.begin(), run.cells.end());
  return order;
}

}  // namespace firn
