#include "core/control/mpc/descent.h"

#include <algorithm>
#include <vector>

namespace firn::control::mpc {
namespace {

class Descent {
 public:
  Descent(HorizonObjective& objective, int layers, std::int64_t most) : objective_(objective), layers_(layers), most_(most) {
    stale_.assign(objective.grid().size(), 1);
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
          if (!(objective_.gain_mm(move) < -kLeastGain_mm)) continue;
          objective_.apply(move);
          ++result_.moves;
          note(cell);
        }
    }
    return true;
  }

  // (For alpha < 1 the deviation couples all points, weakly: the last look at every point settles that.)
  void note(std::uint32_t cell) {
    const GridSpec& g = objective_.grid();
    const int ci = int(cell) % g.nx, cj = int(cell) / g.nx, reach = objective_.reach();
    for (int j = std::max(cj - reach, 0); j <= std::min(cj + reach, g.ny - 1); ++j)
      for (int i = std::max(ci - reach, 0); i <= std::min(ci + reach, g.nx - 1); ++i) stale_[g.index(i, j)] = 1;
  }

  HorizonObjective& objective_;
  int layers_;
  std::int64_t most_;
  SearchResult result_;
  std::vector<std::uint8_t> stale_;  // per cell: something near it changed since it was last tried
};

}  // namespace

SearchResult descend(HorizonObjective& objective, int layers, std::int64_t max_evaluations) {
  return Descent(objective, layers, max_evaluations).run();
}

}  // namespace firn::control::mpc
