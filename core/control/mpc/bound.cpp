#include "core/control/mpc/bound.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/control/mpc/strip_kernel.h"

namespace firn::control::mpc {
namespace {

// Single precision rounds each of a column's few terms by 2^-24 of its size; twice that, over all terms, is taken off.
constexpr double kRounding = 1.0 / (1 << 22);

template <int M>
class Decomposition {
 public:
  static constexpr int K = M + 2;
  using Column = StripColumn<K, M>;

  Decomposition(const LayerProblem& problem, double known_mm)
      : nx_(problem.nx()), strips_((problem.ny() + M - 1) / M), known_mm_(known_mm), parts_(std::size_t(strips_)) {
    LayerProblem bare = problem;
    bare.clear();
    for (int s = 0; s < strips_; ++s) load(bare, s);
    multipliers_.assign(std::size_t(std::max(0, strips_ - 1)) * 2 * std::size_t(nx_), 0.0f);
    direction_.assign(multipliers_.size(), 0.0f);
  }

  LowerBound ascend(const BoundOptions& o, const ParallelFor& parallel) {
    LowerBound found;
    found.rows = M;
    double scale = 1.0;
    int since_better = 0;
    for (; found.iterations < o.iterations; ++found.iterations) {
      const double now = evaluate(parallel);
      if (found.iterations == 0 || now > found.total_mm) {
        found.total_mm = now, found.multipliers = multipliers_, since_better = 0;
      } else if (++since_better == kPatience) {
        scale *= 0.5, since_better = 0;
        multipliers_ = found.multipliers;
        std::fill(direction_.begin(), direction_.end(), 0.0f);
        found.history_mm.push_back(found.total_mm);
        continue;
      }
      found.history_mm.push_back(found.total_mm);
      if (known_mm_ - found.total_mm <= o.gap * known_mm_ || !step(scale * (known_mm_ - now))) break;
    }
    return found;
  }

 private:
  static constexpr int kPatience = 12;
  static constexpr float kMemory = 0.7f;  // of the direction

  struct Part {
    std::vector<Column> columns;
    std::vector<std::uint8_t> barred, choice;
    std::vector<int> patterns;
    double minimum_mm = 0.0, gross_mm = 0.0;
  };

  // Strip s counts rows [s M, s M + M); bit b is row s M - 1 + b.
  void load(const LayerProblem& bare, int s) {
    Part& p = parts_[std::size_t(s)];
    const std::size_t n = std::size_t(nx_);
    std::vector<float> effects(n * 9 * K, 0.0f);
    const auto inside = [&](int j) { return j >= 0 && j < bare.ny(); };
    for (int b = 0; b < K; ++b)
      if (const int j = s * M - 1 + b; inside(j)) bare.effects(j, effects.data() + std::size_t(b) * 9 * n);
    p.columns.resize(n + 2), p.barred.resize(n), p.choice.resize(n << (2 * K)), p.patterns.resize(n);
    for (int x = 0; x < nx_; ++x) {
      Column& c = p.columns[std::size_t(x) + 1];
      for (int b = 0; b < K; ++b) {
        const int j = s * M - 1 + b;
        p.barred[std::size_t(x)] |= std::uint8_t((!inside(j) || !bare.printable(x, j)) << b);
      }
      fill_column<K, M>(c, effects.data() + x, n, 1, p.barred[std::size_t(x)]);
      for (int r = 0; r < M; ++r) {
        c.error[r] = inside(s * M + r) ? bare.error_mm(x, s * M + r) : 0.0f;
        p.gross_mm += std::abs(double(c.error[r]));
        for (int side = 0; side < 3; ++side) p.gross_mm += double(c.adds[side][r][Column::S - 1]);
      }
    }
    fill_edge<K, M>(p.columns.front());
    fill_edge<K, M>(p.columns.back());
  }

  const float* cut(int k, int side) const { return multipliers_.data() + std::size_t(2 * k + side) * std::size_t(nx_); }

  void minimise(int s) {
    Part& p = parts_[std::size_t(s)];
    double paid = 0.0;
    for (int x = 0; x < nx_; ++x) {
      float of_row[K] = {};
      if (s > 0) of_row[0] -= cut(s - 1, 0)[x], of_row[1] -= cut(s - 1, 1)[x];
      if (s + 1 < strips_) of_row[M] += cut(s, 0)[x], of_row[M + 1] += cut(s, 1)[x];
      float* price = p.columns[std::size_t(x) + 1].price;
      price[0] = 0.0f;
      for (int b = 0; b < K; ++b) {
        for (int q = 0; q < 1 << b; ++q) price[q | 1 << b] = price[q] + of_row[b];
        paid += std::abs(double(of_row[b]));
      }
      for (int q = 0; q < Column::S; ++q)
        if (q & p.barred[std::size_t(x)]) price[q] = kNever;
    }
    const double sum = solve_strip<K, M>(p.columns.data(), nx_, p.choice.data(), p.patterns.data());
    p.minimum_mm = sum - kRounding * (p.gross_mm + paid);
  }

  double evaluate(const ParallelFor& parallel) {
    parallel(strips_, [this](int s) { minimise(s); });
    double sum = 0.0;
    for (const Part& p : parts_) sum += p.minimum_mm;
    return sum;
  }

  // Moves the multipliers along the deflected supergradient so that the bound would rise by `rise_mm` if it were linear.
  // False when the copies agree: the bound is the optimum.
  bool step(double rise_mm) {
    double norm = 0.0;
    for (int k = 0; k + 1 < strips_; ++k)
      for (int side = 0; side < 2; ++side) {
        float* d = direction_.data() + std::size_t(2 * k + side) * std::size_t(nx_);
        const std::vector<int>&upper = parts_[std::size_t(k)].patterns, &lower = parts_[std::size_t(k) + 1].patterns;
        for (int x = 0; x < nx_; ++x) {
          const int g = (upper[std::size_t(x)] >> (M + side) & 1) - (lower[std::size_t(x)] >> side & 1);
          d[x] = float(g) + kMemory * d[x];
          norm += double(d[x]) * double(d[x]);
        }
      }
    if (!(norm > 0.0)) return false;
    const float length = float(rise_mm / norm);
    for (std::size_t i = 0; i < multipliers_.size(); ++i) multipliers_[i] += length * direction_[i];
    return true;
  }

  int nx_, strips_;
  double known_mm_;
  std::vector<Part> parts_;
  std::vector<float> multipliers_, direction_;
};

template <int M>
LowerBound bound(const LayerProblem& problem, double known_mm, const BoundOptions& o, const ParallelFor& parallel) {
  return Decomposition<M>(problem, known_mm).ascend(o, parallel);
}

}  // namespace

LowerBound lower_bound(const LayerProblem& problem, double known_mm, const BoundOptions& o, const ParallelFor& parallel) {
  switch (o.rows) {
    case 2: return bound<2>(problem, known_mm, o, parallel);
    case 3: return bound<3>(problem, known_mm, o, parallel);
    case 4: return bound<4>(problem, known_mm, o, parallel);
    default: throw std::invalid_argument("bound rows = " + std::to_string(o.rows) + " is outside 2..4");
  }
}

}  // namespace firn::control::mpc
