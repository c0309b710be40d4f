#include "core/control/mpc/layer/dual_decomposition.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace firn::control::mpc {
namespace {

constexpr int kGroup = 64;  // strips that one thread visits one after the other

}  // namespace

// Tables of every step from cell to cell, one column beyond the strip's last so that its windows are complete
// too.
struct DualDecomposition::Work {
  Work(int nx, int high)
      : high(high),
        steps((nx + 1) * high),
        effects(std::size_t(nx) * 9 * std::size_t(high)),
        tables(std::size_t(steps) * kWindowPatterns) {}
  float* table(int x, int b) { return tables.data() + std::size_t(x * high + b) * kWindowPatterns; }
  float* states(std::vector<float>& of, int step) const {
    return of.data() + std::size_t(step) * profile_states(high);
  }

  int high, steps;
  std::vector<float> effects, tables, after, before;
};

DualDecomposition::DualDecomposition(const LayerProblem& problem, int rows, const CellCost& cost)
    : bare_(problem),
      rows_(rows),
      nx_(problem.nx()),
      ny_(problem.ny()),
      strips_((problem.ny() + rows - 1) / std::max(1, rows)),
      cost_(cost) {
  if (rows < 1 || rows > 4)
    throw std::invalid_argument("bound rows = " + std::to_string(rows) + " is outside 1..4");
  bare_.clear();
  shared_.assign(std::size_t(strips_ - 1) * std::size_t(nx_) * kSharedPatterns, 0.0f);
}

void DualDecomposition::fill_tables(int s, Work& work) const {
  const std::size_t n = std::size_t(nx_);
  const int K = high();
  const auto inside = [&](int j) { return j >= 0 && j < ny_; };
  for (int b = 0; b < K; ++b) {
    float* of_row = work.effects.data() + std::size_t(b) * 9 * n;
    if (inside(first_row(s) + b))
      bare_.effects(first_row(s) + b, of_row);
    else
      std::fill(of_row, of_row + 9 * n, 0.0f);
  }
  for (int x = 0; x <= nx_; ++x)
    for (int b = 0; b < K; ++b) {
      float* table = work.table(x, b);
      const int middle = x - 1, j = first_row(s) + b - 1;  // the cell whose window is complete
      if (b >= 2 && middle >= 0 && inside(j) && bare_.printable(middle, j)) {
        std::array<float, 9> adds{};
        for (int column = 0; column < 3; ++column)
          for (int bit = 0; bit < 3; ++bit) {
            const int from = x - 2 + column;  // rows b, b - 1, b - 2 lie +1, 0, -1 from the middle
            if (from < 0 || from >= nx_) continue;
            const std::size_t q = std::size_t(bit * 3 + 2 - column);
            adds[std::size_t(3 * column + bit)] =
                work.effects[(std::size_t(b - bit) * 9 + q) * n + std::size_t(from)];
          }
        cost_table(bare_.error_mm(middle, j), adds, cost_, table);
      } else {
        zero_table(table);
      }
      if (middle >= 0 && b == 1 && s > 0) add_shared(table, shared(s - 1, middle), -1.0f);
      if (middle >= 0 && b == K - 1 && s + 1 < strips_) add_shared(table, shared(s, middle), 1.0f);
      const int latest = first_row(s) + b;
      if (x == nx_ || !inside(latest) || !bare_.printable(x, latest))
        bar_latest(table);
      else if (cost_.outside > 0.0f && b >= 1 &&
               b <= rows_)  // once: by the strip in which its own cell counts
        price_latest(table, cost_.outside * bare_.outside_mm(x, latest));
    }
}

double DualDecomposition::visit(int s, SweepDirection direction, Work& work) {
  const int K = high(), at = direction == SweepDirection::kDown ? K - 1 : 1,
            cut = direction == SweepDirection::kDown ? s : s - 1;
  const bool gives = cut >= 0 && cut + 1 < strips_;
  const std::size_t states = profile_states(K);
  fill_tables(s, work);
  work.after.resize(states * std::size_t(work.steps + 1));
  std::fill(work.after.end() - std::ptrdiff_t(states), work.after.end(), 0.0f);
  double minimum = 0.0;
  for (int p = work.steps - 1; p >= 0; --p) {
    step_backward(K, work.states(work.after, p + 1), work.table(0, p), work.states(work.after, p));
    if (p % K == 0) minimum += double(take_off_least(K, work.states(work.after, p)));
  }
  minimum += double(work.after[0]);  // before the first cell: no droplets
  if (!gives) return minimum;

  work.before.assign(2 * states, kBarred);
  float *before = work.before.data(), *next = before + states;
  before[0] = 0.0f;
  for (int p = 0; p < work.steps; ++p) {
    float* table = work.table(0, p);
    const int middle = p / K - 1;
    if (p % K == at && middle >= 0) {
      float least[kSharedPatterns];
      min_by_pattern(K, before, table, work.states(work.after, p + 1), least);
      const float best = *std::min_element(least, least + kSharedPatterns);
      for (float& v : least) v = v > 0.5f * kBarred ? 0.0f : v - best;
      add_shared(table, least, -1.0f);
      float* values = shared_.data() + (shared(cut, middle) - shared_.data());
      for (int q = 0; q < kSharedPatterns; ++q)
        values[q] += direction == SweepDirection::kDown ? -least[q] : least[q];
    }
    step_forward(K, before, table, next);
    std::swap(before, next);
    if (p % K == 0) take_off_least(K, before);
  }
  return minimum;
}

double DualDecomposition::sweep(SweepDirection direction, const ParallelFor& parallel) {
  const int groups = (strips_ + kGroup - 1) / kGroup;
  std::vector<double> minima(std::size_t(strips_), 0.0);
  for (int phase = 0; phase < 2; ++phase) {  // neighbouring groups change the same cut
    const int parity = direction == SweepDirection::kDown ? phase : 1 - phase;
    parallel((groups - parity + 1) / 2, [&](int n) {
      const int first = (2 * n + parity) * kGroup, last = std::min(strips_, first + kGroup);
      Work work(nx_, high());
      for (int k = first; k < last; ++k) {
        const int s = direction == SweepDirection::kDown ? k : first + last - 1 - k;
        minima[std::size_t(s)] = visit(s, direction, work);
      }
    });
  }
  double sum = 0.0;
  for (const double m : minima) sum += m;
  return sum;
}

void DualDecomposition::decide(SweepDirection direction, LayerProblem& layer) const {
  const int K = high();
  const std::size_t states = profile_states(K);
  Work work(nx_, K);
  work.before.resize(states * std::size_t(work.steps + 1));
  for (int n = 0; n < strips_; ++n) {
    const int s = direction == SweepDirection::kDown ? n : strips_ - 1 - n;
    fill_tables(s, work);
    if (n > 0)
      for (const int b :
           {direction == SweepDirection::kDown ? 0 : K - 2, direction == SweepDirection::kDown ? 1 : K - 1})
        if (const int j = first_row(s) + b; j >= 0 && j < ny_)
          for (int x = 0; x < nx_; ++x) set_latest(work.table(x, b), layer.drop(x, j));
    std::fill_n(work.before.begin(), states, kBarred);
    work.before[0] = 0.0f;
    for (int p = 0; p < work.steps; ++p) {
      step_forward(K, work.states(work.before, p), work.table(0, p), work.states(work.before, p + 1));
      if (p % K == 0) take_off_least(K, work.states(work.before, p + 1));
    }
    const float* last = work.states(work.before, work.steps);
    int state = int(std::min_element(last, last + states) - last);
    for (int p = work.steps - 1; p >= 0; --p) {
      const int x = p / K, j = first_row(s) + p % K;
      if (x < nx_ && j >= 0 && j < ny_) layer.set_drop(x, j, std::uint8_t(state & 1));
      state = state_before(K, work.states(work.before, p), work.table(0, p), state);
    }
  }
  layer.refresh();
}

}  // namespace firn::control::mpc
