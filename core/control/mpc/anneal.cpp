#include "core/control/mpc/anneal.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/control/mpc/delta_cache.h"

namespace firn::control::mpc {
namespace {

constexpr int kBits = 10, kEntries = 1 << kBits, kPerDraw = 6;
constexpr int kSweepsPerRefresh = 16;

// -ln((i + 1/2) / kEntries): how many temperatures the change of a draw i may cost.
std::array<double, kEntries> waiting_times() {
  std::array<double, kEntries> t{};
  for (int i = 0; i < kEntries; ++i) {
    double x = (i + 0.5) / kEntries, ln = 0.0;
    constexpr double kLn2 = 0.69314718055994531;
    for (; x < 0.5; x *= 2.0) ln -= kLn2;
    const double z = (x - 1.0) / (x + 1.0);  // ln x = 2 (z + z^3 / 3 + ...), |z| <= 1/3
    double power = z;
    for (int n = 1; n < 40; n += 2, power *= z * z) ln += 2.0 * power / n;
    t[std::size_t(i)] = -ln;
  }
  return t;
}

const std::array<double, kEntries>& waits() {
  static const std::array<double, kEntries> table = waiting_times();
  return table;
}

// Temperature of a sweep [mm of one cell].
double temperature_mm(const AnnealOptions& o, int sweep) {
  const double rest = double(o.sweeps - sweep) / o.sweeps;
  return o.cold_mm + (o.hot_mm - o.cold_mm) * rest * rest;
}

class Draws {
 public:
  explicit Draws(RandomStream& random) : random_(random) {}
  std::uint64_t next(int bits) {
    if (left_ == 0) {
      bits_ = random_.bits();
      left_ = kPerDraw;
    }
    --left_;
    const std::uint64_t value = bits_ & std::uint64_t((1 << bits) - 1);
    bits_ >>= bits;
    return value;
  }

 private:
  RandomStream& random_;
  std::uint64_t bits_ = 0;
  int left_ = 0;
};

// sqrt(now) - sqrt(before), by the squares' difference: nothing cancels.
struct Root {
  explicit Root(double square) : before(std::max(0.0, square)), root(std::sqrt(before)) {}
  double rise_to(double square) const {
    const double now = std::max(0.0, square), roots = std::sqrt(now) + root;
    return roots > 0.0 ? (now - before) / roots : 0.0;
  }
  double before, root;
};

// Cost of a plan after a flip, from the objective deltas.
class FlipCost {
 public:
  FlipCost(const HorizonState& field, const PlanCost& cost)
      : field_(field), cost_(cost), per_cell_(1.0 / field.cells) {
    note();
  }
  static DeltaCache::Wanted wanted(const PlanCost& cost) {
    if (cost.error == ErrorKind::kSquare) return DeltaCache::Wanted::kSquares;
    return cost.alpha < 1.0 ? DeltaCache::Wanted::kBoth : DeltaCache::Wanted::kAbsolute;
  }
  void note() {  // the sums have changed
    squares_ = field_.second_mm2 + cost_.price_mm2 * field_.droplets;
    mean_part_ = cost_.mean_weight * field_.first_mm * field_.first_mm * per_cell_;
    error_ = Root((squares_ + mean_part_) * per_cell_);
    const double mean = field_.first_mm * per_cell_;
    deviation_ = Root(field_.second_mm2 * per_cell_ - mean * mean);
  }
  double worse_mm(const ObjectiveDeltas& s, double sign) const {
    double worse = cost_.alpha * s.abs_error_mm;
    if (cost_.error == ErrorKind::kSquare)
      worse = cost_.alpha * field_.cells *
              error_.rise_to((squares_ + s.second_mm2 + cost_.price_mm2 * sign + mean_part(s)) * per_cell_);
    if (cost_.alpha < 1.0) {
      const double mean = (field_.first_mm + s.first_mm) * per_cell_;
      worse += (1.0 - cost_.alpha) * field_.cells *
               deviation_.rise_to((field_.second_mm2 + s.second_mm2) * per_cell_ - mean * mean);
    }
    return worse;
  }

 private:
  double mean_part(const ObjectiveDeltas& s) const {
    const double sum_mm = field_.first_mm + s.first_mm;
    return cost_.mean_weight * sum_mm * sum_mm * per_cell_;
  }

  const HorizonState& field_;
  const PlanCost& cost_;
  double per_cell_, squares_ = 0.0, mean_part_ = 0.0;
  Root error_{0.0}, deviation_{0.0};
};

// One sweep; false when the evaluations are used up.
bool sweep_field(const HorizonState& f, DeltaCache& flips, FlipCost& cost,
                 std::span<const std::uint32_t> cells, int layers, double temperature, std::int64_t most,
                 Draws& draws, SearchResult& result) {
  for (const std::uint32_t cell : cells) {
    const std::size_t p = f.at(cell);
    for (int layer = 0; layer < layers; ++layer) {
      if (result.evaluations >= most) return false;
      ++result.evaluations;
      const double sign = f.layers[std::size_t(layer)].drops[p] ? -1.0 : 1.0;
      if (cost.worse_mm(flips.sums(layer, p), sign) > temperature * waits()[draws.next(kBits)]) continue;
      flips.flip(layer, p);
      cost.note();
      ++result.moves;
    }
  }
  return true;
}

}  // namespace

SearchResult anneal(HorizonState& f, const PlanCost& cost, std::span<const std::uint32_t> cells,
                    const AnnealOptions& o, RandomStream& random) {
  SearchResult result;
  Draws draws(random);
  DeltaCache flips(f, FlipCost::wanted(cost));
  FlipCost of_flip(f, cost);
  for (int n = 0; n < o.sweeps; ++n) {
    if (n % kSweepsPerRefresh == 0) {
      flips.refresh();
      of_flip.note();
    }
    if (!sweep_field(f, flips, of_flip, cells, o.layers, temperature_mm(o, n), o.max_evaluations, draws,
                     result))
      break;
  }
  f.refresh();
  return result;
}

SearchResult anneal(HorizonObjective& objective, std::span<const std::uint32_t> cells, const AnnealOptions& o,
                    RandomStream& random) {
  const double per_cell = 1.0 / double(objective.part_cells().size());
  const bool up_or_down = objective.max_drops() > 1;
  SearchResult result;
  Draws draws(random);
  for (int sweep = 0; sweep < o.sweeps; ++sweep) {
    const double temperature = temperature_mm(o, sweep) * per_cell;
    if (sweep % kSweepsPerRefresh == 0) objective.refresh();
    for (const std::uint32_t cell : cells)
      for (int layer = 0; layer < o.layers; ++layer) {
        Move move{layer, cell, objective.layer(layer).cells[cell] == 0 ? 1 : -1};
        if (up_or_down) {
          move.change = draws.next(1) ? 1 : -1;
          if (!objective.allowed(move)) move = {layer, cell, -move.change};
        }
        if (result.evaluations >= o.max_evaluations) {
          objective.refresh();
          return result;
        }
        ++result.evaluations;
        if (objective.gain_mm(move) > temperature * waits()[draws.next(kBits)]) continue;
        objective.apply(move);
        ++result.moves;
      }
  }
  objective.refresh();
  return result;
}

}  // namespace firn::control::mpc
