#include "core/grid/offsets.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace firn {
namespace {

double place_along(int k, int n) { return double(2 * k + 1 - n) / double(2 * n); }

std::string name(const GridSpec& g, std::size_t cell) {
  return "cell (" + std::to_string(cell % std::size_t(g.nx)) + ", " +
         std::to_string(cell / std::size_t(g.nx)) + ")";
}

}  // namespace

OffsetTable::OffsetTable(const OffsetOptions& o) : offsets_{{}}, small_share_(o.small_share) {
  check_options("actuation", kOffsetOptions, o);
  const int nx = o.offsets == OffsetKind::kNone ? 1 : o.positions_x,
            ny = o.offsets == OffsetKind::kGrid ? o.positions_y : 1;
  for (int b = 0; b < ny; ++b)
    for (int a = 0; a < nx; ++a)
      if (const Offset at{place_along(a, nx), place_along(b, ny)}; at != Offset{}) offsets_.push_back(at);
  places_ = int(offsets_.size());
  const int sizes = o.small_share > 0.0 ? 2 : 1;
  if (sizes * places_ > kMaxPlaces)
    throw std::invalid_argument("actuation.small_share: " + std::to_string(places_) +
                                " places of two sizes of droplet are more than " +
                                std::to_string(kMaxPlaces));
  for (int n = 0; sizes == 2 && n < places_; ++n) offsets_.push_back(Offset(offsets_[std::size_t(n)]));
  std::vector<double> heights;
  for (const Offset& at : offsets_) heights.push_back(at.y);
  std::ranges::sort(heights);
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
  sub_rows_ = int(heights.size());
  for (const Offset& at : offsets_)
    sub_row_.push_back(int(std::ranges::find(heights, at.y) - heights.begin()));
}

int OffsetTable::nearest(Offset p) const {
  const auto squared = [&](const Offset& at) {
    return (at.x - p.x) * (at.x - p.x) + (at.y - p.y) * (at.y - p.y);
  };
  return int(std::ranges::min_element(offsets_, {}, squared) - offsets_.begin());
}

void check(const Placement& p, const GridSpec& grid) {
  if (p.map.cells.empty()) return;
  if (p.map.size() != grid.size())
    throw std::invalid_argument("offsets: " + std::to_string(p.map.size()) + " of them for a grid of " +
                                std::to_string(grid.size()) + " cells");
  for (std::size_t c = 0; c < p.map.size(); ++c)
    if (p.map.of(c) >= p.table.size())
      throw std::invalid_argument("offsets: that of " + name(grid, c) + " is " + std::to_string(p.map.of(c)) +
                                  ", and actuation.offsets has " + std::to_string(p.table.size()) +
                                  " places");
}

StagePlace stage_place(const GridSpec& g, int i, int j, Offset offset, const Aim& aim, bool towards_plus_x) {
  const double direction = towards_plus_x ? 1.0 : -1.0;
  return {g.x_mm(i) + offset.x * g.pitch_x_mm - aim.nozzle_x_mm - direction * aim.lead_mm,
          g.y_mm(j) + offset.y * g.pitch_y_mm - aim.nozzle_y_mm};
}

StagePlace part_place(StagePlace stage, const Aim& aim, bool towards_plus_x) {
  const double direction = towards_plus_x ? 1.0 : -1.0;
  return {stage.x_mm + aim.nozzle_x_mm + direction * aim.lead_mm, stage.y_mm + aim.nozzle_y_mm};
}

}  // namespace firn
