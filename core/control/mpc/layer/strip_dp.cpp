#include "core/control/mpc/layer/strip_dp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/control/mpc/layer/strip_kernel.h"

namespace firn::control::mpc {
namespace {

constexpr double kMinGainPerCell_mm = 1e-9;

// The best droplets of rows [first, first + K) of all columns, everything else fixed.
template <int K>
class Strip {
 public:
  static constexpr int R = K + 2;  // rows that the strip's droplets reach
  using Column = StripColumn<K, R>;
  explicit Strip(int nx)
      : columns_(std::size_t(nx) + 2),
        effects_(std::size_t(nx) * 9 * K),
        choice_(std::size_t(nx) << (2 * K)),
        pattern_(std::size_t(nx)),
        present_(std::size_t(nx) + 2) {}

  // @returns whether the objective fell; the problem has the better droplets then.
  bool improve(LayerProblem& problem, int first, const CellCost& cost) {
    load(problem, first);
    if (cost.outside > 0.0f) add_prices(problem, first, cost.outside);
    solve_strip<K, R>(columns_.data(), problem.nx(), cost, choice_.data(), pattern_.data());
    return apply(problem, first, cost);
  }

 private:
  void load(const LayerProblem& problem, int first);
  void add_prices(const LayerProblem& problem, int first, float price);
  bool apply(LayerProblem& problem, int first, const CellCost& cost);

  std::vector<Column> columns_;  // one empty column at each end
  std::vector<float> effects_;   // of the strip's rows
  std::vector<std::uint8_t> choice_;
  std::vector<int> pattern_;  // found
  std::vector<int> present_;  // before; one 0 at each end
};

template <int K>
void Strip<K>::load(const LayerProblem& problem, int first) {
  const int nx = problem.nx();
  for (int b = 0; b < K; ++b)
    problem.effects(first + b, effects_.data() + std::size_t(b) * 9 * std::size_t(nx));
  for (int x = 0; x < nx; ++x) {
    int barred = 0, present = 0;
    for (int b = 0; b < K; ++b) {
      present |= int(problem.drop(x, first + b)) << b;
      barred |= int(!problem.printable(x, first + b)) << b;
    }
    present_[std::size_t(x) + 1] = present;
    Column& c = columns_[std::size_t(x) + 1];
    fill_column<K, R>(c, effects_.data() + x, std::size_t(nx), -1, barred);
    for (int r = 0; r < R; ++r) c.error[r] = problem.error_row(first - 1 + r)[x];
  }
  fill_edge<K, R>(columns_.front());
  fill_edge<K, R>(columns_.back());
  for (int x = 0; x < nx; ++x) {  // errors with the strip empty
    Column* c = &columns_[std::size_t(x) + 1];
    const int* u = &present_[std::size_t(x) + 1];
    for (int r = 0; r < R; ++r)
      c->error[r] -= c[-1].adds[2][r][u[-1]] + c->adds[1][r][u[0]] + c[1].adds[0][r][u[1]];
  }
}

template <int K>
void Strip<K>::add_prices(const LayerProblem& problem, int first, float price) {
  for (int x = 0; x < problem.nx(); ++x)
    for (int b = 0; b < K; ++b) {
      if (!problem.printable(x, first + b)) continue;
      const float of_drop = price * problem.outside_mm(x, first + b);
      if (of_drop == 0.0f) continue;
      for (int s = 0; s < Column::S; ++s)
        if (s >> b & 1) columns_[std::size_t(x) + 1].price[s] += of_drop;
    }
}

template <int K>
bool Strip<K>::apply(LayerProblem& problem, int first, const CellCost& cost) {
  const int nx = int(pattern_.size());
  double gain = 0.0;
  bool differs = false;
  const auto pattern = [&](int x) { return x < 0 || x >= nx ? 0 : pattern_[std::size_t(x)]; };
  for (int x = 0; x < nx; ++x) {
    const Column* c = &columns_[std::size_t(x) + 1];
    const int* u = &present_[std::size_t(x) + 1];
    differs = differs || pattern(x) != u[0];
    gain += double(c->price[u[0]]) - double(c->price[pattern(x)]);
    for (int r = 0; r < R; ++r) {
      const double before =
          double(c->error[r]) + c[-1].adds[2][r][u[-1]] + c->adds[1][r][u[0]] + c[1].adds[0][r][u[1]];
      const double after = double(c->error[r]) + c[-1].adds[2][r][pattern(x - 1)] +
                           c->adds[1][r][pattern(x)] + c[1].adds[0][r][pattern(x + 1)];
      gain += cost_of(cost, before) - cost_of(cost, after);
    }
  }
  if (!differs || !(gain > kMinGainPerCell_mm * nx * R)) return false;  // below lies rounding
  for (int x = 0; x < nx; ++x)
    for (int b = 0; b < K; ++b) problem.set_drop(x, first + b, std::uint8_t(pattern(x) >> b & 1));
  return true;
}

template <int K>
StripResult sweep(LayerProblem& problem, const StripOptions& options, const ParallelFor& parallel) {
  const int strips = problem.ny() - K + 1, classes = K + 2;
  StripResult result;
  std::vector<std::uint8_t> stale(std::size_t(strips), 1), improved(std::size_t(strips), 0);
  std::vector<int> due;
  for (; result.sweeps < options.max_sweeps; ++result.sweeps) {
    bool any = false;
    for (int k = 0; k < classes; ++k) {
      due.clear();
      for (int first = k; first < strips; first += classes)
        if (stale[std::size_t(first)]) due.push_back(first);
      if (due.empty()) continue;
      any = true;
      constexpr int kBatch = 8;
      parallel((int(due.size()) + kBatch - 1) / kBatch, [&](int batch) {
        Strip<K> strip(problem.nx());
        for (int n = batch * kBatch; n < std::min(int(due.size()), (batch + 1) * kBatch); ++n)
          improved[std::size_t(due[std::size_t(n)])] =
              strip.improve(problem, due[std::size_t(n)], options.cost);
      });
      for (const int first : due) {
        ++result.strips;
        stale[std::size_t(first)] = 0;
        if (!improved[std::size_t(first)]) continue;
        ++result.improved;
        // Strips that see an error or a droplet of these rows: those up to K + 1 rows away.
        for (int other = std::max(0, first - K - 1); other <= std::min(strips - 1, first + K + 1); ++other)
          if (other != first) stale[std::size_t(other)] = 1;
      }
    }
    if (!any) {
      result.settled = true;
      break;
    }
  }
  return result;
}

}  // namespace

StripResult sweep_strips(LayerProblem& problem, const StripOptions& o, const ParallelFor& parallel) {
  if (o.rows < 1 || o.rows > 6)
    throw std::invalid_argument("strip rows = " + std::to_string(o.rows) + " is outside 1..6");
  const StripOptions fitted{std::min(o.rows, problem.ny()), o.max_sweeps, o.cost};
  switch (fitted.rows) {
    case 1:
      return sweep<1>(problem, fitted, parallel);
    case 2:
      return sweep<2>(problem, fitted, parallel);
    case 3:
      return sweep<3>(problem, fitted, parallel);
    case 4:
      return sweep<4>(problem, fitted, parallel);
    case 5:
      return sweep<5>(problem, fitted, parallel);
    default:
      return sweep<6>(problem, fitted, parallel);
  }
}

}  // namespace firn::control::mpc
