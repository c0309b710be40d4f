#include "core/deposition/offset_change.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

namespace firn::deposition {
namespace {

constexpr int kRadius = OffsetKernel::kRadius;

void check_kernels(const OffsetModel& m) {
  if (int(m.kernels.size()) != m.table.size())
    throw std::invalid_argument("droplet model: " + std::to_string(m.kernels.size()) + " kernels for " +
                                std::to_string(m.table.size()) + " places");
}

}  // namespace

double OffsetKernel::drop_height_mm() const {
  double sum = 0.0;
  for (const double h : height_mm) sum += h;
  return sum;
}

OffsetKernel kernel_of(const DropletModel& model) { return mixed_kernel(model, {}); }

OffsetKernel mixed_kernel(const DropletModel& model, Offset place) {
  const Stencil<1> centre = stencil_of(model);
  const double x = std::abs(place.x), y = std::abs(place.y);
  const int sx = place.x < 0.0 ? -1 : 1, sy = place.y < 0.0 ? -1 : 1;
  OffsetKernel k;
  const struct {
    int i, j;
    double share;
  } cells[] = {
      {0, 0, (1.0 - x) * (1.0 - y)}, {sx, 0, x * (1.0 - y)}, {0, sy, (1.0 - x) * y}, {sx, sy, x * y}};
  for (const auto& [i, j, share] : cells)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        k.height_mm[OffsetKernel::index(i + dx, j + dy)] += share * centre.at(dx, dy);
  return k;
}

OffsetModel offset_model(const DropletModel& model, const OffsetTable& table,
                         std::span<const double> heights_mm, double range_mm) {
  check(model);
  const std::size_t wanted = std::size_t(table.size() - 1) * OffsetKernel::kCells;
  if (!heights_mm.empty() && heights_mm.size() != wanted)
    throw std::invalid_argument("actuation.heights_mm has " + std::to_string(heights_mm.size()) +
                                " heights; " + std::to_string(table.size() - 1) +
                                " places beside the centre need " + std::to_string(wanted));
  if (!kFlowRange_mm.holds(range_mm))
    throw std::invalid_argument("actuation.flow_range_mm = " + shortest_text(range_mm) + " mm is outside " +
                                text(kFlowRange_mm));
  OffsetModel m{table, {kernel_of(model)}, range_mm};
  for (int n = 1; n < table.size(); ++n) {
    OffsetKernel k = mixed_kernel(model, table[n]);
    for (double& h : k.height_mm) h *= table.share(n);
    if (!heights_mm.empty())
      std::copy_n(heights_mm.begin() + std::ptrdiff_t((n - 1) * OffsetKernel::kCells), OffsetKernel::kCells,
                  k.height_mm.begin());
    for (const double h : k.height_mm)
      if (!kPlaceHeight_mm.holds(h))
        throw std::invalid_argument("actuation.heights_mm: a height of place " + std::to_string(n) + ", " +
                                    shortest_text(h) + " mm, is outside " + text(kPlaceHeight_mm));
    if (k.at(0, 0) <= 0.0)
      throw std::invalid_argument("actuation.heights_mm: place " + std::to_string(n) +
                                  " adds nothing to its own cell");
    m.kernels.push_back(k);
  }
  return m;
}

OffsetChange::OffsetChange(const GridSpec& grid, OffsetModel model, Border border, OffsetModel model_b)
    : grid_(grid),
      model_(std::move(model)),
      model_b_(std::move(model_b)),
      border_(border),
      change_(grid.size()) {
  firn::check(grid);
  check_kernels(model_);
  check_kernels(model_b_);
}

Ledger OffsetChange::deposit(HeightMap& height, const DropletPattern& drops, const OffsetMap& offsets,
                             const MaterialMap& inks) {
  if (height.size() != grid_.size() || drops.size() != grid_.size() ||
      (inks.size() != 0 && inks.size() != grid_.size()))
    throw std::invalid_argument("deposit: height has " + std::to_string(height.size()) + " cells, drops " +
                                std::to_string(drops.size()) + ", the grid " + std::to_string(grid_.size()));
  firn::check(Placement{model_.table, offsets, 0.0}, grid_);
  check_finite(height, "deposit");
  Ledger ledger;
  const int passes = drops.passes();
  for (int pass = 0; pass < passes; ++pass) {
    std::fill(change_.begin(), change_.end(), 0.0);
    for (int j = 0; j < grid_.ny; ++j)
      for (int i = 0; i < grid_.nx; ++i) {
        const std::size_t c = grid_.index(i, j);
        if (drops.cells[c] <= pass) continue;
        const OffsetModel& ink = inks.size() != 0 && inks.of(c) == Material::kB ? model_b_ : model_;
        const OffsetKernel& k = ink.kernels[std::size_t(offsets.of(c))];
        double kept_mm = k.drop_height_mm();
        ++ledger.drops;
        ledger.deposited_mm += kept_mm;
        for (int dy = -kRadius; dy <= kRadius; ++dy)
          for (int dx = -kRadius; dx <= kRadius; ++dx) {
            const double w_mm = k.at(dx, dy);
            if ((dx == 0 && dy == 0) || w_mm == 0.0) continue;
            if (grid_.contains(i + dx, j + dy)) {
              const std::size_t n = grid_.index(i + dx, j + dy);
              const double given_mm =
                  w_mm * sat(ink.range_of(offsets.of(c), w_mm), height.cells[c] - height.cells[n]);
              change_[n] += given_mm;
              kept_mm -= given_mm;
            } else if (border_ == Border::kLose) {
              kept_mm -= w_mm;
              ledger.lost_mm += w_mm;
            }
          }
        change_[c] += kept_mm;
      }
    for (std::size_t c = 0; c < change_.size(); ++c) height.cells[c] += change_[c];
  }
  return ledger;
}

}  // namespace firn::deposition
