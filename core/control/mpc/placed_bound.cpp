#include "core/control/mpc/placed_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace firn::control::mpc {
namespace {

constexpr double kForbidden = 1e30;
constexpr int kPowers[] = {1, 3, 9};

int symbol(int pattern, int row) { return pattern / kPowers[row] % PlacedBound::kSymbols; }

}  // namespace

// The terms of one row of errors: rows 0, 1, 2 of droplets, the middle one that of the errors.
struct PlacedBound::Strip {
  std::vector<std::vector<int>> patterns;  // allowed ones of each column
  std::vector<std::array<double, kPatterns>> from[3],
      own;  // heights from columns x - 1, x, x + 1; prices of a column
};

PlacedBound::PlacedBound(const PlacedObjective& layer)
    : nx_(layer.grid().nx),
      ny_(layer.grid().ny),
      square_(layer.cost().error == ErrorKind::kSquare),
      cells_(layer.grid().size()) {
  const GridSpec& g = layer.grid();
  for (std::size_t n = 0; n < layer.cells().size(); ++n) {
    const std::uint32_t at = layer.cells()[n];
    Cell& c = cells_[at];
    c.part = true;
    c.symbols = 1 + layer.choices(n);
    if (c.symbols > kSymbols) throw std::invalid_argument("placed bound: a cell offers more than two places");
    c.error_mm = layer.error_mm(n);
    for (int s = 1; s < c.symbols; ++s) {
      c.price[s] = layer.price(n, s - 1);
      for (int q = 0; q < 9; ++q) c.adds_mm[s][q] = layer.adds_mm(n, s - 1, q % 3 - 1, q / 3 - 1);
    }
    constexpr int kReach = deposition::OffsetKernel::kRadius;
    const int i = int(at) % g.nx, j = int(at) / g.nx;
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        if ((std::abs(dx) < 2 && std::abs(dy) < 2) || !g.contains(i + dx, j + dy)) continue;
        double most_mm = 0.0;
        for (int s = 1; s < c.symbols; ++s) most_mm = std::max(most_mm, layer.adds_mm(n, s - 1, dx, dy));
        cells_[g.index(i + dx, j + dy)].slack_mm += most_mm;
      }
  }
  shared_.assign(std::size_t(std::max(0, ny_ - 1)) * std::size_t(nx_) * std::size_t(kShared), 0.0);
}

const PlacedBound::Cell* PlacedBound::cell(int i, int j) const {
  if (i < 0 || j < 0 || i >= nx_ || j >= ny_) return nullptr;
  const Cell& c = cells_[std::size_t(j) * std::size_t(nx_) + std::size_t(i)];
  return c.part ? &c : nullptr;
}

double PlacedBound::cost(const Cell& c, double adds_mm) const {
  const double e = c.error_mm - adds_mm, least = e > c.slack_mm ? e - c.slack_mm : e < 0.0 ? -e : 0.0;
  return square_ ? least * least : least;
}

double PlacedBound::visit(int row, bool down) {
  Strip s;
  s.patterns.resize(std::size_t(nx_) + 2);
  for (auto& f : s.from) f.assign(std::size_t(nx_), {});
  s.own.assign(std::size_t(nx_), {});
  const auto patterns = [&](int x) -> const std::vector<int>& { return s.patterns[std::size_t(x + 1)]; };
  for (int x = -1; x <= nx_; ++x)
    for (int p = 0; p < kPatterns; ++p) {
      bool allowed = true;
      for (int r = 0; r < 3; ++r) {
        const Cell* c = cell(x, row - 1 + r);
        allowed = allowed && symbol(p, r) < (c ? c->symbols : 1);
      }
      if (allowed) s.patterns[std::size_t(x + 1)].push_back(p);
    }
  for (int x = 0; x < nx_; ++x) {
    for (int dx = -1; dx <= 1; ++dx)
      for (const int p : patterns(x + dx))
        for (int r = 0; r < 3; ++r)
          if (const Cell* c = cell(x + dx, row - 1 + r))
            s.from[dx + 1][std::size_t(x)][std::size_t(p)] +=
                c->adds_mm[symbol(p, r)][(1 - r + 1) * 3 - dx + 1];
    for (const int p : patterns(x))
      if (const Cell* c = cell(x, row)) s.own[std::size_t(x)][std::size_t(p)] = c->price[symbol(p, 1)];
  }
  const auto two = [](int p, int first) { return symbol(p, first) * 3 + symbol(p, first + 1); };
  const auto window = [&](int a, int b, int n, int first) {
    return two(a, first) * 81 + two(b, first) * 9 + two(n, first);
  };
  const auto cost_at = [&](int x, int a, int b, int n) {
    double sum = s.own[std::size_t(x)][std::size_t(b)];
    if (const Cell* c = cell(x, row))
      sum += cost(*c, s.from[0][std::size_t(x)][std::size_t(a)] + s.from[1][std::size_t(x)][std::size_t(b)] +
                          s.from[2][std::size_t(x)][std::size_t(n)]);
    if (row > 0) sum -= shared(row - 1, x)[window(a, b, n, 0)];
    if (row + 1 < ny_) sum += shared(row, x)[window(a, b, n, 1)];
    return sum;
  };
  using Table = std::array<double, std::size_t(kPatterns) * std::size_t(kPatterns)>;  // [b][n]
  std::vector<Table> after(std::size_t(nx_) + 1);  // of columns from x on: [a][b]
  after[std::size_t(nx_)].fill(0.0);
  const auto at = [](int a, int b) { return std::size_t(a * kPatterns + b); };
  for (int x = nx_ - 1; x >= 0; --x)
    for (const int a : patterns(x - 1))
      for (const int b : patterns(x)) {
        double best = kForbidden;
        for (const int n : patterns(x + 1))
          best = std::min(best, cost_at(x, a, b, n) + after[std::size_t(x + 1)][at(b, n)]);
        after[std::size_t(x)][at(a, b)] = best;
      }
  double minimum = kForbidden;
  for (const int b : patterns(0)) minimum = std::min(minimum, after[0][at(0, b)]);
  const int cut = down ? row : row - 1;
  if (cut < 0 || cut + 1 >= ny_) return minimum;
  Table before, next;
  before.fill(0.0);
  for (int x = 0; x < nx_; ++x) {
    std::array<double, kShared> least;
    least.fill(kForbidden);
    for (const int a : patterns(x - 1))
      for (const int b : patterns(x))
        for (const int n : patterns(x + 1)) {
          double& w = least[std::size_t(window(a, b, n, down ? 1 : 0))];
          w = std::min(w, before[at(a, b)] + cost_at(x, a, b, n) + after[std::size_t(x + 1)][at(b, n)]);
        }
    const double best = *std::ranges::min_element(least);
    double* to = shared(cut, x);
    for (std::size_t w = 0; w < std::size_t(kShared); ++w)
      if (least[w] < 0.5 * kForbidden) to[w] += (down ? -1.0 : 1.0) * (least[w] - best);
    next.fill(kForbidden);
    for (const int a : patterns(x - 1))
      for (const int b : patterns(x))
        for (const int n : patterns(x + 1))
          next[at(b, n)] = std::min(next[at(b, n)], before[at(a, b)] + cost_at(x, a, b, n));
    before = next;
  }
  return minimum;
}

double PlacedBound::sweep(bool down) {
  double sum = 0.0;
  for (int n = 0; n < ny_; ++n) sum += visit(down ? n : ny_ - 1 - n, down);
  return sum;
}

std::string placed_reached(const PlacedObjective& empty, const MpcOptions& o, double value_mm) {
  constexpr int kSweepsForGap = 100;  // the bound has converged by then
  const double cells = double(empty.cells().size()),
               found = (o.error == ErrorKind::kSquare ? value_mm * value_mm : value_mm) * cells;
  const int most = o.gap > 0.0 ? std::max(o.sweeps, kSweepsForGap) : o.sweeps;
  PlacedBound split(empty);
  double bound = 0.0;
  int sweeps = 0;
  while (sweeps < most && !(sweeps > 0 && found - bound <= o.gap * found)) {
    const double now = split.sweep(sweeps % 2 == 0);
    bound = sweeps == 0 ? now : std::max(bound, now);
    ++sweeps;
  }
  if (sweeps == 0 || !(found > 0.0)) return "; without a bound";
  return "; after " + std::to_string(sweeps) + (sweeps == 1 ? " sweep" : " sweeps") +
         ", no layer is better by more than " + std::to_string(100.0 * std::max(0.0, 1.0 - bound / found)) +
         " %";
}

double certified_placed_bound(const Setup& s, const HeightMap& height, const PlanCost& cost,
                              const OffsetMap& second, std::span<const double> multipliers) {
  const GridSpec& g = s.grid;
  const bool square = cost.error == ErrorKind::kSquare;
  constexpr int kReach = deposition::OffsetKernel::kRadius;
  const auto part = [&](int i, int j) { return g.contains(i, j) && s.mask.at(i, j) != 0; };
  // The kernel of a symbol on a cell; a droplet whose kernel cannot reach beside the part has the centre
  // alone.
  const auto kernel = [&](int i, int j, int which) -> const deposition::OffsetKernel* {
    if (!part(i, j) || which == 0) return nullptr;
    if (which == 1) return &s.offsets.kernels.front();
    bool edge = false;
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) edge = edge || !part(i + dx, j + dy);
    const int place = second.of(g.index(i, j));
    return edge && place != 0 ? &s.offsets.kernels[std::size_t(place)] : nullptr;
  };
  const auto adds = [&](int i, int j, const deposition::OffsetKernel& k, int dx, int dy) {
    const auto flow = [&](int fx, int fy) {
      const double w = k.at(fx, fy);
      if (!g.contains(i + fx, j + fy)) return s.border == deposition::Border::kLose ? w : 0.0;
      return w * deposition::sat(std::max(s.offsets.range_mm, k.at(0, 0) + w),
                                 height.at(i, j) - height.at(i + fx, j + fy));
    };
    if (dx != 0 || dy != 0) return flow(dx, dy);
    double own = k.drop_height_mm();
    for (int fy = -kReach; fy <= kReach; ++fy)
      for (int fx = -kReach; fx <= kReach; ++fx)
        if (fx != 0 || fy != 0) own -= flow(fx, fy);
    return own;
  };
  // Row by row the least cost over columns, by a table of the symbols of two columns.
  double bound = 0.0;
  for (int row = 0; row < g.ny; ++row) {
    const auto symbols = [&](int p, int r) {
      return (p >> (2 * r)) & 3;
    };  // 0 none, 1 centre, 2 second; two bits a row
    std::vector<std::vector<int>> open(std::size_t(g.nx) + 2);
    for (int x = -1; x <= g.nx; ++x)
      for (int p = 0; p < 64; ++p) {
        bool ok = true;
        for (int r = 0; r < 3; ++r)
          ok = ok && (symbols(p, r) == 0 ||
                      (symbols(p, r) < 3 && kernel(x, row - 1 + r, symbols(p, r)) != nullptr));
        if (ok) open[std::size_t(x + 1)].push_back(p);
      }
    std::vector<double> best(64 * 64, std::numeric_limits<double>::infinity());
    for (const int b : open[1]) best[std::size_t(b)] = 0.0;
    for (int x = 0; x < g.nx; ++x) {
      double slack_mm = 0.0;
      const bool counts = part(x, row);
      if (counts)
        for (int dy = -kReach; dy <= kReach; ++dy)
          for (int dx = -kReach; dx <= kReach; ++dx) {
            if (std::abs(dx) < 2 && std::abs(dy) < 2) continue;
            double most = 0.0;
            for (const int which : {1, 2})
              if (const auto* k = kernel(x + dx, row + dy, which))
                most = std::max(most, adds(x + dx, row + dy, *k, -dx, -dy));
            slack_mm += most;
          }
      std::array<std::array<double, 64>, 3> from{};
      std::array<double, 64> price{};
      for (int dx = -1; dx <= 1; ++dx)
        for (const int p : open[std::size_t(x + dx + 1)])
          for (int r = 0; r < 3; ++r)
            if (const auto* k = kernel(x + dx, row - 1 + r, symbols(p, r)))
              from[std::size_t(dx + 1)][std::size_t(p)] += adds(x + dx, row - 1 + r, *k, -dx, 1 - r);
      for (const int p : open[std::size_t(x + 1)])
        if (const auto* k = kernel(x, row, symbols(p, 1))) {
          double beside_mm = 0.0;
          for (int dy = -kReach; dy <= kReach; ++dy)
            for (int dx = -kReach; dx <= kReach; ++dx)
              if (!part(x + dx, row + dy)) beside_mm += adds(x, row, *k, dx, dy);
          price[std::size_t(p)] =
              cost.outside_price * (square ? s.model.layer_height_mm() : 1.0) * beside_mm +
              (square ? cost.price_mm2 : 0.0);
        }
      const auto paid = [&](int cut, int first, int a, int b, int n) {
        if (cut < 0 || cut + 1 >= g.ny) return 0.0;
        const auto two = [&](int p) { return std::size_t(symbols(p, first) * 3 + symbols(p, first + 1)); };
        return multipliers[(std::size_t(cut) * std::size_t(g.nx) + std::size_t(x)) * 729 + two(a) * 81 +
                           two(b) * 9 + two(n)];
      };
      std::vector<double> next(64 * 64, std::numeric_limits<double>::infinity());
      for (const int a : open[std::size_t(x)])
        for (const int b : open[std::size_t(x + 1)])
          for (const int n : open[std::size_t(x + 2)]) {
            double sum = best[std::size_t(a * 64 + b)] + price[std::size_t(b)] + paid(row, 1, a, b, n) -
                         paid(row - 1, 0, a, b, n);
            if (counts) {
              const double e = s.target.at(x, row) - height.at(x, row) - from[0][std::size_t(a)] -
                               from[1][std::size_t(b)] - from[2][std::size_t(n)];
              const double least = std::max({0.0, -e, e - slack_mm});
              sum += square ? least * least : least;
            }
            next[std::size_t(b * 64 + n)] = std::min(next[std::size_t(b * 64 + n)], sum);
          }
      best.swap(next);
    }
    bound += *std::ranges::min_element(best);
  }
  return bound;
}

}  // namespace firn::control::mpc
