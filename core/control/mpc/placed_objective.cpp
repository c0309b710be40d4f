#include "core/control/mpc/placed_objective.h"

#include <algorithm>
#include <cmath>

namespace firn::control::mpc {
namespace {

bool at_edge(const Setup& s, int i, int j, int reach) {
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx)
      if (!s.grid.contains(i + dx, j + dy) || !s.mask.at(i + dx, j + dy)) return true;
  return false;
}

}  // namespace

PlacedObjective::PlacedObjective(const Setup& s, const HeightMap& height, const MaterialMap& inks,
                                 const PlanCost& cost, const OffsetMap* second)
    : grid_(s.grid),
      cost_(cost),
      outside_price_(cost.error == ErrorKind::kSquare ? cost.outside_price * s.model.layer_height_mm()
                                                      : cost.outside_price),
      droplet_price_(cost.error == ErrorKind::kSquare ? cost.price_mm2 : 0.0),
      row_(std::size_t(s.grid.nx) + 2 * kRadius) {
  error_.assign(row_ * (std::size_t(s.grid.ny) + 2 * kRadius), 0.0);
  counts_.assign(error_.size(), 0);
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i) {
      if (!s.mask.at(i, j)) continue;
      counts_[padded(i, j)] = 1;
      error_[padded(i, j)] = s.target.at(i, j) - height.at(i, j);
    }
  first_.push_back(0);
  for (std::uint32_t c = 0; c < s.grid.size(); ++c) {
    if (!s.mask.cells[c]) continue;
    const int i = int(c) % s.grid.nx, j = int(c) / s.grid.nx;
    const deposition::OffsetModel& model =
        inks.size() != 0 && inks.of(c) == Material::kB ? s.offsets_b : s.offsets;
    const int places = at_edge(s, i, j, kRadius) ? model.table.size() : 1;
    for (int place = 0; place < places; ++place) {
      if (second != nullptr && place != 0 && place != second->of(c)) continue;
      effects_.push_back(effect(s, height, i, j, model, place));
      places_.push_back(std::uint8_t(place));
    }
    cells_.push_back(c);
    corner_.push_back(padded(i - kRadius, j - kRadius));
    first_.push_back(int(effects_.size()));
  }
  chosen_.assign(cells_.size(), kNone);
}

PlacedObjective::Effect PlacedObjective::effect(const Setup& s, const HeightMap& height, int i, int j,
                                                const deposition::OffsetModel& model, int place) const {
  const deposition::OffsetKernel& k = model.kernels[std::size_t(place)];
  Effect e{};
  double own_mm = k.drop_height_mm(), outside_mm = 0.0;
  for (int dy = -kRadius; dy <= kRadius; ++dy)
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      if (dx == 0 && dy == 0) continue;
      double given_mm = k.at(dx, dy);
      if (given_mm == 0.0) continue;
      const bool on_grid = s.grid.contains(i + dx, j + dy);
      if (on_grid)
        given_mm *=
            deposition::sat(model.range_of(place, given_mm), height.at(i, j) - height.at(i + dx, j + dy));
      else if (s.border == deposition::Border::kKeep)
        given_mm = 0.0;
      own_mm -= given_mm;
      if (counts_[padded(i + dx, j + dy)])
        e.mm[deposition::OffsetKernel::index(dx, dy)] = given_mm;
      else
        outside_mm += given_mm;
    }
  e.mm[deposition::OffsetKernel::index(0, 0)] = own_mm;
  const double share = model.table.share(place);  // its scatter is relative
  e.price = outside_price_ * outside_mm + share * share * droplet_price_;
  return e;
}

template <class Visit>
void PlacedObjective::over(std::size_t n, int choice, const Visit& visit) const {
  const double* mm = effects_[std::size_t(first_[n] + choice)].mm.data();
  std::size_t p = corner_[n];
  for (int y = 0; y < kSide; ++y, p += row_, mm += kSide)
    for (std::size_t x = 0; x < std::size_t(kSide); ++x) visit(p + x, mm[x]);
}

double PlacedObjective::rise_with(std::size_t n, int choice) const {
  double sum = effects_[std::size_t(first_[n] + choice)].price;
  if (cost_.error == ErrorKind::kSquare)
    over(n, choice, [&](std::size_t p, double mm) { sum += mm * (mm - 2.0 * error_[p]); });
  else
    over(n, choice, [&](std::size_t p, double mm) { sum += std::abs(error_[p] - mm) - std::abs(error_[p]); });
  return sum;
}

void PlacedObjective::choose(std::size_t n, int choice) {
  const auto add = [&](int which, double sign) {
    over(n, which, [&](std::size_t p, double mm) { error_[p] -= sign * mm; });
    prices_ += sign * effects_[std::size_t(first_[n] + which)].price;
  };
  if (chosen_[n] == choice) return;
  if (chosen_[n] != kNone) add(chosen_[n], -1.0);
  if (choice != kNone) add(choice, 1.0);
  chosen_[n] = choice;
}

double PlacedObjective::error_mm(std::size_t n) const {
  return error_[corner_[n] + std::size_t(kRadius) * row_ + std::size_t(kRadius)];
}

double PlacedObjective::value_mm() const {
  const double cells = double(cells_.size());
  double sum = prices_;
  for (std::size_t p = 0; p < error_.size(); ++p)
    if (counts_[p]) sum += cost_.error == ErrorKind::kSquare ? error_[p] * error_[p] : std::abs(error_[p]);
  return cost_.error == ErrorKind::kSquare ? std::sqrt(std::max(0.0, sum / cells)) : sum / cells;
}

DropletPattern PlacedObjective::drops() const {
  DropletPattern u(grid_);
  for (std::size_t n = 0; n < cells_.size(); ++n) u.cells[cells_[n]] = chosen_[n] != kNone;
  return u;
}

OffsetMap PlacedObjective::offsets() const {
  OffsetMap map(grid_);
  bool any = false;
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    if (chosen_[n] == kNone) continue;
    map.cells[cells_[n]] = places_[std::size_t(first_[n] + chosen_[n])];
    any = any || map.cells[cells_[n]] != 0;
  }
  return any ? map : OffsetMap{};
}

}  // namespace firn::control::mpc
