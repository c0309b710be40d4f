#include "core/deposition/height_change.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/deposition/row_kernels.h"

namespace firn::deposition {
namespace {

void require_weight(bool ok, const std::string& name, double value, const char* limit) {
  if (!ok)
    throw std::invalid_argument("droplet model: " + name + " = " + std::to_string(value) + " mm must be " +
                                limit);
}

Link make_link(int dx, int dy, double w_mm, double centre_mm) {
  return {dx, dy, w_mm, w_mm / (centre_mm + w_mm)};
}

// Flows of one ink: the vectorised row.
struct UniformFlow {
  static constexpr bool kUniform = true;
  double drop_height_mm;
  double weight(const Link& link, std::size_t) const { return link.w_mm; }
};

// Flows where every droplet has its own weights.
template <int Radius>
struct VariedFlow {
  static constexpr bool kUniform = false;
  std::span<const Stencil<Radius>> stencils;
  double weight(const Link& link, std::size_t cell) const { return stencils[cell].at(link.dx, link.dy); }
  double spread(const Link& link, std::size_t cell, double drop_mm) const {
    const Stencil<Radius>& s = stencils[cell];
    return make_link(link.dx, link.dy, s.at(link.dx, link.dy), s.centre_mm).spread_mm(drop_mm);
  }
};

}  // namespace

void check(const DropletModel& m) { check_options("droplet model", kDropletModel, m); }

void check_finite(const HeightMap& height, const char* what) {
  for (std::size_t c = 0; c < height.size(); ++c)
    if (!std::isfinite(height.cells[c]))
      throw std::invalid_argument(std::string(what) + ": height of cell (" +
                                  std::to_string(c % std::size_t(height.spec.nx)) + ", " +
                                  std::to_string(c / std::size_t(height.spec.nx)) + ") is not finite");
}

Stencil<1> stencil_of(const DropletModel& m) { return {m.h1_mm, {m.h2_mm, m.h3_mm}}; }

template <int Radius>
std::vector<Link> links_of(const Stencil<Radius>& s) {
  std::vector<Link> links;
  for (int dy = -Radius; dy <= Radius; ++dy)
    for (int dx = -Radius; dx <= Radius; ++dx)
      if (dx != 0 || dy != 0) links.push_back(make_link(dx, dy, s.at(dx, dy), s.centre_mm));
  return links;
}

template <int Radius>
double Stencil<Radius>::drop_height_mm() const {
  double sum = centre_mm;
  for (int p = 1; p <= Radius; ++p)
    for (int q = 0; q <= p; ++q) sum += (q == 0 || q == p ? 4.0 : 8.0) * at(p, q);
  return sum;
}

template <int Radius>
HeightChange<Radius>::HeightChange(const GridSpec& grid, const Stencil<Radius>& stencil, Border border)
    : grid_(grid), stencil_(stencil), border_(border), width_(std::size_t(grid.nx)) {
  firn::check(grid);
  require_weight(std::isfinite(stencil.centre_mm) && stencil.centre_mm > 0.0, "centre", stencil.centre_mm,
                 "above 0");
  for (double w : stencil.ring_mm)
    require_weight(std::isfinite(w) && w >= 0.0, "ring weight", w, "not negative");
  for (const Link& link : links_of(stencil))
    if (link.dy > 0 || (link.dy == 0 && link.dx > 0)) forward_.push_back(link);
  drops_.assign(width_ * (Radius + 1), 0.0);
  change_.assign(width_ * (Radius + 1), 0.0);
  flow_.assign(width_, 0.0);
}

template <int Radius>
template <class Flow>
Ledger HeightChange<Radius>::run(double* height, const std::uint8_t* drops, int pass, const Flow& flow) {
  Ledger ledger;
  const RowKernels& kernels = row_kernels();
  const auto load = [&](int j) {
    ledger.drops += kernels.load(drops + std::size_t(j) * width_, pass, row_of(drops_, j), width_);
  };
  const int nx = grid_.nx, ny = grid_.ny;
  std::fill(change_.begin(), change_.end(), 0.0);
  for (int j = 0; j < std::min(Radius, ny); ++j) load(j);
  for (int j = 0; j < ny; ++j) {
    if (j + Radius < ny) load(j + Radius);
    const double* u = row_of(drops_, j);
    double* change = row_of(change_, j);
    double* h = height + std::size_t(j) * width_;
    const std::size_t first = std::size_t(j) * width_;

    for (const Link& link : forward_) {  // each pair of neighbours once: both directions
      if (j + link.dy >= ny) continue;
      const int begin = std::max(0, -link.dx), n = nx - std::abs(link.dx);
      if (n <= 0) continue;
      const double* hn = h + std::size_t(link.dy) * width_ + begin + link.dx;
      const double* un = row_of(drops_, j + link.dy) + begin + link.dx;
      double* to = row_of(change_, j + link.dy) + begin + link.dx;
      if constexpr (Flow::kUniform) {
        kernels.flow(h + begin, hn, u + begin, un, link.w_mm, link.slope, flow_.data(), change + begin, to,
                     std::size_t(n));
      } else {
        const std::size_t c = first + std::size_t(begin);
        const std::ptrdiff_t step = std::ptrdiff_t(link.dy) * nx + link.dx;
        for (int i = 0; i < n; ++i) {
          double f = 0.0;
          const double d = h[begin + i] - hn[i];
          if (u[begin + i] != 0.0) f += flow.spread(link, c + std::size_t(i), d);
          if (un[i] != 0.0) f -= flow.spread(link, std::size_t(std::ptrdiff_t(c) + i + step), -d);
          flow_[std::size_t(i)] = f;
        }
        for (int i = 0; i < n; ++i) change[begin + i] -= flow_[std::size_t(i)];
        for (int i = 0; i < n; ++i) to[i] += flow_[std::size_t(i)];
      }
    }

    if (border_ == Border::kLose) {  // flow to cells off the grid is lost (sat = 1)
      const bool inner = j >= Radius && j < ny - Radius;
      for (int i = 0; i < nx; ++i) {
        if (inner && i == Radius && nx > 2 * Radius) i = nx - Radius;
        if (u[i] == 0.0) continue;
        for (const Link& link : forward_)
          for (int sign : {1, -1}) {
            const int x = i + sign * link.dx, y = j + sign * link.dy;
            if (grid_.contains(x, y)) continue;
            const double w = flow.weight(link, first + std::size_t(i));
            change[i] -= w;
            ledger.lost_mm += w;
          }
      }
    }

    // Row j has met every row it is linked to; its place in the ring becomes row j + Radius + 1.
    if constexpr (Flow::kUniform) {
      kernels.settle(h, u, flow.drop_height_mm, change, width_);
    } else {
      for (int i = 0; i < nx; ++i) {
        const double own = u[i] != 0.0 ? flow.stencils[first + std::size_t(i)].drop_height_mm() : 0.0;
        ledger.deposited_mm += own;
        h[i] += own + change[i];
        change[i] = 0.0;
      }
    }
  }
  if constexpr (Flow::kUniform) ledger.deposited_mm = double(ledger.drops) * flow.drop_height_mm;
  total_ += ledger;
  return ledger;
}

template <int Radius>
Ledger HeightChange<Radius>::step(double* height_mm, const std::uint8_t* drops, int pass) {
  return run(height_mm, drops, pass, UniformFlow{stencil_.drop_height_mm()});
}

template <int Radius>
Ledger HeightChange<Radius>::step(double* height_mm, const std::uint8_t* drops, int pass,
                                  std::span<const Stencil<Radius>> stencils) {
  return run(height_mm, drops, pass, VariedFlow<Radius>{stencils});
}

template <int Radius>
Ledger HeightChange<Radius>::deposit(HeightMap& height, const DropletPattern& drops) {
  if (height.size() != grid_.size() || drops.size() != grid_.size())
    throw std::invalid_argument("deposit: height has " + std::to_string(height.size()) + " cells, drops " +
                                std::to_string(drops.size()) + ", the grid " + std::to_string(grid_.size()));
  check_finite(height, "deposit");
  Ledger sum;
  const int passes = drops.passes();
  for (int p = 0; p < passes; ++p) sum += step(height.data(), drops.data(), p);
  return sum;
}

Ledger deposit_additive(HeightMap& height, const DropletPattern& drops, const DropletModel& model) {
  check(model);
  if (height.size() != drops.size())
    throw std::invalid_argument("deposit_additive: height and drops differ in size");
  const GridSpec& g = drops.spec;
  Ledger ledger;
  const auto links = links_of(stencil_of(model));
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double u = drops.at(i, j);
      if (u == 0.0) continue;
      height.at(i, j) += model.h1_mm * u;
      for (const Link& link : links) {
        if (g.contains(i + link.dx, j + link.dy))
          height.at(i + link.dx, j + link.dy) += link.w_mm * u;
        else
          ledger.lost_mm += link.w_mm * u;
      }
      ledger.drops += drops.at(i, j);
    }
  ledger.deposited_mm = double(ledger.drops) * model.layer_height_mm();
  return ledger;
}

template struct Stencil<1>;
template struct Stencil<2>;
template std::vector<Link> links_of(const Stencil<1>&);
template std::vector<Link> links_of(const Stencil<2>&);
template class HeightChange<1>;
template class HeightChange<2>;

}  // namespace firn::deposition
