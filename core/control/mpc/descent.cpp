#include "core/control/mpc/descent.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace firn::control::mpc {
namespace {

class Descent {
 public:
  Descent(HorizonObjective& objective, int layers, std::int64_t most, DeltaCache* flips)
      : objective_(objective),
        layers_(layers),
        most_(most),
        flips_(objective.alpha() == 1.0 ? flips : nullptr) {
    stale_.assign(objective.grid().size(), 1);
    if (flips_ != nullptr) set_margins();
  }

  SearchResult run() {
    for (;;) {
      const std::int64_t before = result_.moves;
      if (!sweep()) return result_;
      if (result_.moves != before) continue;
      objective_.refresh();  // a last look at every point, without rounding drift
      std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
      if (!sweep()) return result_;
      if (result_.moves != before) continue;
      result_.optimal = true;
      return result_;
    }
  }

 private:
  // Every cell near which something changed, once. False when the evaluations are used up.
  bool sweep() {
    for (const std::uint32_t cell : objective_.part_cells()) {
      if (!stale_[cell]) continue;
      stale_[cell] = 0;
      for (int layer = 0; layer < layers_; ++layer)
        for (const int change : {1, -1}) {
          const Move move{layer, cell, change};
          if (!objective_.allowed(move)) continue;
          if (result_.evaluations >= most_) return false;
          ++result_.evaluations;
          if (flips_ != nullptr && surely_worse(move)) continue;
          if (!(objective_.gain_mm(move) < -kMinGain_mm)) continue;
          objective_.apply(move);
          if (flips_ != nullptr) flips_->flip(layer, flips_->field().at(cell));
          ++result_.moves;
          note(cell);
        }
    }
    return true;
  }

  // Heights in single precision err by some 1e-7 of themselves, the sums over a window by less than this.
  void set_margins() {
    constexpr float kPart = 1e-5f;
    const HorizonState& f = flips_->field();
    float height_mm = 0.0f, error_mm = f.ink[0].drop_mm + f.ink[1].drop_mm;
    for (const std::uint32_t cell : objective_.part_cells()) {
      const std::size_t p = f.at(cell);
      height_mm = std::max({height_mm, std::abs(f.layers.front().height_mm[p]), std::abs(f.error_mm[p])});
      error_mm = std::max(error_mm, std::abs(f.error_mm[p]));
    }
    height_mm = std::max(height_mm, f.outside_error_mm());
    margin_mm_ = double(kPart * height_mm);
    margin_mm2_ = margin_mm_ * double(error_mm);
  }

  bool surely_worse(const Move& m) const {
    const ObjectiveDeltas s = flips_->sums(m.layer, flips_->field().at(m.cell));
    const PlanCost& cost = objective_.cost();
    if (cost.error == ErrorKind::kSquare) {
      const HorizonState& f = flips_->field();
      const double mean_part = cost.mean_weight * s.first_mm * (2.0 * f.first_mm + s.first_mm) / f.cells;
      return s.second_mm2 + cost.price_mm2 * m.change + mean_part > margin_mm2_;
    }
    return s.abs_error_mm > margin_mm_;
  }

  // (For alpha < 1 the deviation couples all points, weakly: the last look at every point settles that.)
  void note(std::uint32_t cell) {
    const GridSpec& g = objective_.grid();
    const int ci = int(cell) % g.nx, cj = int(cell) / g.nx, reach = objective_.reach();
    for (int j = std::max(cj - reach, 0); j <= std::min(cj + reach, g.ny - 1); ++j)
      for (int i = std::max(ci - reach, 0); i <= std::min(ci + reach, g.nx - 1); ++i)
        stale_[g.index(i, j)] = 1;
  }

  HorizonObjective& objective_;
  int layers_;
  std::int64_t most_;
  DeltaCache* flips_;  // or none
  double margin_mm_ = 0.0, margin_mm2_ = 0.0;
  SearchResult result_;
  std::vector<std::uint8_t> stale_;  // per cell: something near it changed since it was last tried
};

}  // namespace

SearchResult descend(HorizonObjective& objective, int layers, std::int64_t max_evaluations,
                     DeltaCache* flips) {
  return Descent(objective, layers, max_evaluations, flips).run();
}

}  // namespace firn::control::mpc
