#include "core/control/mpc/anneal.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/control/mpc/flip_kernel.h"

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
    if (left_ == 0) bits_ = random_.bits(), left_ = kPerDraw;
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
FIRN_INLINE double roots_apart(double before, double now) {
  before = std::max(0.0, before), now = std::max(0.0, now);
  const double roots = std::sqrt(now) + std::sqrt(before);
  return roots > 0.0 ? (now - before) / roots : 0.0;
}

// One sweep; false when the evaluations are used up.
FIRN_INLINE bool sweep_field(PlanField& f, const PlanCost& cost, std::span<const std::uint32_t> cells, int layers, double temperature,
                             std::int64_t most, Draws& draws, SearchResult& result) {
  const double per_cell = 1.0 / f.cells;
  Flip flip;
  for (const std::uint32_t cell : cells) {
    const std::size_t p = f.at(cell);
    for (int layer = 0; layer < layers; ++layer) {
      if (result.evaluations >= most) return false;
      ++result.evaluations;
      make_flip(f, layer, p, flip);
      FlipSums s;
      sums_of(f, layer, p, flip, s);
      double worse = cost.alpha * s.abs_error_mm;
      if (cost.error == ErrorKind::kSquare) {
        const double squares = f.second_mm2 + cost.price_mm2 * f.droplets;
        worse = cost.alpha * f.cells * roots_apart(squares * per_cell, (squares + s.second_mm2 + cost.price_mm2 * double(flip.sign)) * per_cell);
      }
      if (cost.alpha < 1.0) {
        const double mean = f.first_mm * per_cell, mean_now = (f.first_mm + s.first_mm) * per_cell;
        worse += (1.0 - cost.alpha) * f.cells *
                 roots_apart(f.second_mm2 * per_cell - mean * mean, (f.second_mm2 + s.second_mm2) * per_cell - mean_now * mean_now);
      }
      if (worse > temperature * waits()[draws.next(kBits)]) continue;
      keep_flip(f, layer, p, flip, s);
      ++result.moves;
    }
  }
  return true;
}

bool sweep_portable(PlanField& f, const PlanCost& cost, std::span<const std::uint32_t> cells, int layers, double temperature,
                    std::int64_t most, Draws& draws, SearchResult& result) {
  return sweep_field(f, cost, cells, layers, temperature, most, draws, result);
}
#if defined(__x86_64__)
__attribute__((target("avx2"))) bool sweep_avx2(PlanField& f, const PlanCost& cost, std::span<const std::uint32_t> cells, int layers,
                                                double temperature, std::int64_t most, Draws& draws, SearchResult& result) {
  return sweep_field(f, cost, cells, layers, temperature, most, draws, result);
}
#endif

}  // namespace

SearchResult anneal(PlanField& f, const PlanCost& cost, std::span<const std::uint32_t> cells, const AnnealOptions& o, RandomStream& random) {
  auto sweep = sweep_portable;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) sweep = sweep_avx2;
#endif
  SearchResult result;
  Draws draws(random);
  for (int n = 0; n < o.sweeps; ++n) {
    if (n % kSweepsPerRefresh == 0) f.refresh();
    if (!sweep(f, cost, cells, o.layers, temperature_mm(o, n), o.max_evaluations, draws, result)) break;
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
