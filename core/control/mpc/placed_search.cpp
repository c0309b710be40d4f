#include "core/control/mpc/placed_search.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace firn::control::mpc {
namespace {

constexpr int kPair = 2;                                       // columns and rows between the cells of a pair
constexpr int kTouch = 2 * deposition::OffsetKernel::kRadius;  // between cells that change a common error
constexpr double kLeastGain = 1e-13;  // of a sum [mm or mm^2 of one cell]; below it lies rounding

class PlacedSearch {
 public:
  PlacedSearch(PlacedObjective& objective, std::int64_t most, RandomStream& random)
      : objective_(objective), most_(most), order_(objective.cells().size()) {
    std::iota(order_.begin(), order_.end(), std::uint32_t{0});
    for (std::size_t n = order_.size(); n > 1; --n)
      std::swap(order_[n - 1], order_[random.below(std::uint32_t(n))]);
    rank_.assign(objective.grid().size(), kNoRank);
    for (std::uint32_t n = 0; n < order_.size(); ++n) rank_[objective.cells()[n]] = n;
    stale_.assign(order_.size(), 1);
    unpaired_.assign(order_.size(), 1);
  }

  SearchResult run() {
    while (result_.evaluations < most_) {
      if (singles()) continue;
      if (pairs()) continue;
      result_.optimal = result_.evaluations < most_;
      break;
    }
    return result_;
  }

 private:
  static constexpr std::uint32_t kNoRank = 0xffffffffu;
  struct Best {
    int choice = PlacedObjective::kNone;
    double rise = 0.0;
  };

  // The choice that lowers the sum most for a cell without a droplet.
  Best best(std::size_t n) {
    Best b;
    const int choices = objective_.choices(n);
    for (int c = 0; c < choices; ++c)
      if (const double rise = objective_.rise_with(n, c); rise < b.rise - kLeastGain) b = {c, rise};
    result_.evaluations += choices;
    return b;
  }

  // @returns whether a cell changed
  bool singles() {
    bool any = false;
    for (const std::uint32_t n : order_) {
      if (!stale_[n] || result_.evaluations >= most_) continue;
      stale_[n] = 0;
      const int before = objective_.choice(n);
      objective_.choose(n, PlacedObjective::kNone);
      const double rise = before == PlacedObjective::kNone ? 0.0 : objective_.rise_with(n, before);
      const Best b = best(n);
      const bool better = b.rise < rise - kLeastGain;
      objective_.choose(n, better ? b.choice : before);
      if (!better) continue;
      changed(n);
      any = true;
    }
    return any;
  }

  bool pairs() {
    bool any = false;
    for (const std::uint32_t n : order_) {
      if (!unpaired_[n] || result_.evaluations >= most_) continue;
      unpaired_[n] = 0;
      any = pair(n) || any;
    }
    return any;
  }

  bool pair(std::uint32_t n) {
    const int before = objective_.choice(n);
    objective_.choose(n, PlacedObjective::kNone);
    const double was = before == PlacedObjective::kNone ? 0.0 : objective_.rise_with(n, before);
    for (int c = PlacedObjective::kNone; c < objective_.choices(n); ++c) {
      if (c == before) continue;
      const double step = (c == PlacedObjective::kNone ? 0.0 : objective_.rise_with(n, c)) - was;
      ++result_.evaluations;
      objective_.choose(n, c);
      for (const std::uint32_t other : neighbours(n, kPair)) {
        const int there = objective_.choice(other);
        objective_.choose(other, PlacedObjective::kNone);
        const double rise = there == PlacedObjective::kNone ? 0.0 : objective_.rise_with(other, there);
        const Best b = best(other);
        if (step + b.rise < rise - kLeastGain) {
          objective_.choose(other, b.choice);
          changed(n);
          changed(other);
          return true;
        }
        objective_.choose(other, there);
      }
      objective_.choose(n, PlacedObjective::kNone);
    }
    objective_.choose(n, before);
    return false;
  }

  const std::vector<std::uint32_t>& neighbours(std::uint32_t n, int reach) {
    near_.clear();
    const GridSpec& g = objective_.grid();
    const int ci = int(objective_.cells()[n]) % g.nx, cj = int(objective_.cells()[n]) / g.nx;
    for (int j = std::max(cj - reach, 0); j <= std::min(cj + reach, g.ny - 1); ++j)
      for (int i = std::max(ci - reach, 0); i <= std::min(ci + reach, g.nx - 1); ++i)
        if (const std::uint32_t r = rank_[g.index(i, j)]; r != kNoRank && r != n) near_.push_back(r);
    return near_;
  }

  void changed(std::uint32_t n) {
    ++result_.moves;
    unpaired_[n] = 1;
    for (const std::uint32_t r : neighbours(n, kTouch)) stale_[r] = 1;
    for (const std::uint32_t r : neighbours(n, kTouch + kPair)) unpaired_[r] = 1;
  }

  PlacedObjective& objective_;
  std::int64_t most_;
  SearchResult result_;
  std::vector<std::uint32_t> order_, rank_, near_;
  std::vector<std::uint8_t> stale_, unpaired_;
};

}  // namespace

SearchResult place_droplets(PlacedObjective& objective, std::int64_t most_evaluations, RandomStream& random) {
  return PlacedSearch(objective, most_evaluations, random).run();
}

}  // namespace firn::control::mpc
