#include "core/control/mpc/greedy.h"

#include <algorithm>
#include <vector>

namespace firn::control::mpc {
namespace {

class Search {
 public:
  Search(HorizonObjective& objective, const SearchLimits& limits, RandomStream& random)
      : objective_(objective), limits_(limits), random_(random) {
    const auto cells = objective.moved_cells();
    rank_.assign(objective.grid().size(), kNone);
    for (std::uint32_t n = 0; n < cells.size(); ++n) rank_[cells[n]] = n;
    stale_.assign(cells.size() * std::size_t(objective.horizon()), 1);
  }

  SearchResult run() {
    for (int sweeps = 1;; ++sweeps) {
      collect(kStale);
      const bool all =
          points_.empty();  // nothing is stale: a last look at every point, without rounding drift
      if (all) collect(kAll);
      if (all || sweeps % kSweepsPerRefresh == 0) objective_.refresh();
      const std::int64_t before = result_.moves;
      if (!sweep()) return result_;
      if (all && result_.moves == before) {
        result_.optimal = true;
        return result_;
      }
    }
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  static constexpr int kSweepsPerRefresh = 16;
  // Points that follow each other in a sweep lie so close together that their cells stay in the processor's
  // cache: 160 bytes a cell (one_layer.h). Smaller plans are drawn from as a whole, as in the paper.
  static constexpr std::size_t kBlockPoints = std::size_t(1) << 15;
  enum Which { kStale, kAll };

  void collect(Which which) {
    points_.clear();
    for (std::uint32_t n = 0; n < stale_.size(); ++n)
      if (which == kAll || stale_[n]) points_.push_back(n);
  }

  // The collected points once, in random subsets of each block. False when the evaluations are used up.
  bool sweep() {
    for (std::size_t begin = 0; begin < points_.size();) {
      const std::size_t block = std::min(points_.size(), begin / kBlockPoints * kBlockPoints + kBlockPoints),
                        end = std::min(block, begin + std::size_t(limits_.subset));
      marked_.clear();
      for (std::size_t n = begin; n < end; ++n) {
        std::swap(points_[n], points_[n + below(std::uint32_t(block - n))]);
        const auto cells = objective_.moved_cells();
        const int layer = int(points_[n] / cells.size());
        const std::uint32_t cell = cells[points_[n] % cells.size()];
        stale_[points_[n]] = 0;
        Move best;
        double gain = -kMinGain_mm;
        for (const int change : {1, -1}) {
          const Move move{layer, cell, change};
          if (!objective_.allowed(move)) continue;
          if (result_.evaluations >= limits_.max_evaluations) return false;
          const double g = evaluate(move);
          if (g < gain) {
            gain = g;
            best = move;
          }
        }
        if (best.change != 0) marked_.push_back({best, gain});
      }
      flip_marked();
      begin = end;
    }
    return true;
  }

  void flip_marked() {
    if (marked_.empty()) return;
    const double before = objective_.value_mm();
    for (const auto& m : marked_) objective_.apply(m.move);
    if (marked_.size() == 1 || objective_.value_mm() < before - kMinGain_mm) {
      for (const auto& m : marked_) keep(m.move);
      return;
    }
    for (std::size_t n = marked_.size(); n-- > 0;) objective_.apply(marked_[n].move.undone());
    for (const auto& m : marked_) {
      if (!(evaluate(m.move) < -kMinGain_mm)) continue;
      objective_.apply(m.move);
      keep(m.move);
    }
  }

  // Counts a move and marks the points whose gain it may have changed. (For alpha < 1 the deviation couples
  // all points, weakly: the last look at every point settles that.)
  void keep(const Move& move) {
    ++result_.moves;
    const GridSpec& g = objective_.grid();
    const int ci = int(move.cell) % g.nx, cj = int(move.cell) / g.nx, reach = objective_.reach();
    const std::size_t cells = objective_.moved_cells().size();
    for (int j = std::max(cj - reach, 0); j <= std::min(cj + reach, g.ny - 1); ++j)
      for (int i = std::max(ci - reach, 0); i <= std::min(ci + reach, g.nx - 1); ++i) {
        const std::uint32_t rank = rank_[g.index(i, j)];
        if (rank == kNone) continue;
        for (std::size_t n = rank; n < stale_.size(); n += cells) stale_[n] = 1;
      }
  }

  // Uniform in [0, n): two numbers from each draw.
  std::uint32_t below(std::uint32_t n) {
    if ((spare_ ^= 1u) != 0)
      bits_ = random_.bits();
    else
      bits_ >>= 32;
    return std::uint32_t(((bits_ & 0xffffffffu) * n) >> 32);
  }

  double evaluate(const Move& move) {
    ++result_.evaluations;
    return objective_.gain_mm(move);
  }

  struct Marked {
    Move move;
    double gain_mm;
  };
  HorizonObjective& objective_;
  const SearchLimits& limits_;
  RandomStream& random_;
  SearchResult result_;
  std::uint64_t bits_ = 0;
  std::uint32_t spare_ = 0;
  std::vector<std::uint32_t> rank_;    // of each cell among the part's cells
  std::vector<std::uint8_t> stale_;    // per point: something near it changed since it was last tried
  std::vector<std::uint32_t> points_;  // of the present sweep; point = layer * cells + rank
  std::vector<Marked> marked_;
};

}  // namespace

SearchResult greedy_search(HorizonObjective& objective, const SearchLimits& limits, RandomStream& random) {
  return Search(objective, limits, random).run();
}

}  // namespace firn::control::mpc
