#include "core/control/graph/graph_layer.h"

#include <algorithm>
#include <cmath>

namespace firn::control::graph {
namespace {

// Calls f(edge, a, b) for every pair of neighbours on a grid of nx x ny cells, a owning it.
template <class F>
void each_edge(int nx, int ny, F&& f) {
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i)
      for (std::size_t e = 0; e < kEdges.size(); ++e) {
        const int x = i + kEdges[e][0], y = j + kEdges[e][1];
        if (x >= 0 && x < nx && y < ny)
          f(e, std::size_t(j) * std::size_t(nx) + std::size_t(i),
            std::size_t(y) * std::size_t(nx) + std::size_t(x));
      }
}

// Neighbours of a cell that lie beyond the grid's border.
std::array<int, 2> missing_neighbours(int i, int j, int nx, int ny) {
  std::array<int, 2> missing{0, 0};  // sides, corners
  for (int dj = -1; dj <= 1; ++dj)
    for (int di = -1; di <= 1; ++di)
      if (i + di < 0 || j + dj < 0 || i + di >= nx || j + dj >= ny) ++missing[di != 0 && dj != 0 ? 1 : 0];
  return missing;
}

}  // namespace

GraphModel::GraphModel(const deposition::DropletModel& model, deposition::Border at, int steps_of_layer)
    : droplet_mm(model.layer_height_mm()),
      side(model.h2_mm / (droplet_mm * steps_of_layer)),
      corner(model.h3_mm / (droplet_mm * steps_of_layer)),
      steps(steps_of_layer),
      border(at) {}

Window Window::grown(int by, int nx, int ny) const {
  return {std::max(0, i0 - by), std::min(nx, i1 + by), std::max(0, j0 - by), std::min(ny, j1 + by)};
}

void AffineLayer::flow(std::span<double> z, const Step& step, bool with_constant) const {
  std::vector<double> change =
      with_constant ? step.constant_mm : std::vector<double>(step.constant_mm.size(), 0.0);
  each_edge(nx_, ny_, [&](std::size_t e, std::size_t a, std::size_t b) {
    const double q = step.k[e][a] * (z[a] - z[b]);
    change[a] -= q;
    change[b] += q;
  });
  for (std::size_t n = 0; n < z.size(); ++n) z[n] += change[n];
}

void AffineLayer::change(std::span<double> z, std::span<const double> dose) const {
  for (std::size_t n = 0; n < z.size(); ++n) z[n] += droplet_mm_[n] * dose[n];
  for (const Step& step : steps_) flow(z, step, false);
}

void AffineLayer::apply(std::span<double> z, std::span<const double> dose) const {
  for (std::size_t n = 0; n < z.size(); ++n) z[n] += droplet_mm_[n] * dose[n];
  for (const Step& step : steps_) flow(z, step, true);
}

void AffineLayer::transposed(std::span<double> lambda, std::span<double> by_dose) const {
  // I - D K D' is its own transpose.
  for (std::size_t n = steps_.size(); n-- > 0;) flow(lambda, steps_[n], false);
  for (std::size_t n = 0; n < lambda.size(); ++n) by_dose[n] = droplet_mm_[n] * lambda[n];
}

AffineLayer AffineLayer::on(const Window& w) const {
  AffineLayer part;
  part.nx_ = w.nx();
  part.ny_ = w.ny();
  const auto cut = [&](const std::vector<double>& from) {
    std::vector<double> to;
    to.reserve(w.size());
    for (int j = w.j0; j < w.j1; ++j)
      for (int i = w.i0; i < w.i1; ++i)
        to.push_back(from[std::size_t(j) * std::size_t(nx_) + std::size_t(i)]);
    return to;
  };
  part.droplet_mm_ = cut(droplet_mm_);
  for (const Step& step : steps_) {
    Step s;
    for (std::size_t e = 0; e < kEdges.size(); ++e) s.k[e] = cut(step.k[e]);
    s.constant_mm = cut(step.constant_mm);
    part.steps_.push_back(std::move(s));
  }
  return part;
}

AffineLayer layer_along(const GraphModel& model, const GridSpec& grid, std::span<const double> droplet_mm,
                        std::vector<double>& height, std::span<const double> dose) {
  const std::size_t size = grid.size();
  AffineLayer layer;
  layer.nx_ = grid.nx;
  layer.ny_ = grid.ny;
  layer.droplet_mm_.assign(droplet_mm.begin(), droplet_mm.end());
  std::vector<double> wet(size), z = height, asked(size), change(size), border(size, 0.0);
  for (std::size_t n = 0; n < size; ++n) {
    wet[n] = droplet_mm[n] * dose[n];
    z[n] += wet[n];
  }
  const double range = model.droplet_mm;
  const auto kappa = [&](std::size_t e) { return e < 2 ? model.side : model.corner; };
  if (model.border == deposition::Border::kLose)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const auto [sides, corners] = missing_neighbours(i, j, grid.nx, grid.ny);
        border[grid.index(i, j)] = range * (sides * model.side + corners * model.corner);
      }
  for (int s = 0; s < model.steps; ++s) {
    AffineLayer::Step step;
    for (auto& k : step.k) k.assign(size, 0.0);
    step.constant_mm.assign(size, 0.0);
    asked = border;
    each_edge(grid.nx, grid.ny, [&](std::size_t e, std::size_t a, std::size_t b) {
      const double q = kappa(e) * std::clamp(z[a] - z[b], -range, range);
      asked[q > 0.0 ? a : b] += std::abs(q);
    });
    std::fill(change.begin(), change.end(), 0.0);
    // The share of what its edges ask for that a node can give.
    const auto share = [&](std::size_t n) { return asked[n] > wet[n] ? wet[n] / asked[n] : 1.0; };
    for (std::size_t n = 0; n < size; ++n) {
      if (border[n] == 0.0) continue;
      change[n] -= share(n) * border[n];
      step.constant_mm[n] -= share(n) * border[n];
    }
    each_edge(grid.nx, grid.ny, [&](std::size_t e, std::size_t a, std::size_t b) {
      const double d = z[a] - z[b], k = kappa(e) * share(d > 0.0 ? a : b);
      const double q = k * std::clamp(d, -range, range);
      change[a] -= q;
      change[b] += q;
      if (std::abs(d) < range) {
        step.k[e][a] = k;
      } else {
        step.constant_mm[a] -= q;
        step.constant_mm[b] += q;
      }
    });
    for (std::size_t n = 0; n < size; ++n) {
      wet[n] = std::max(0.0, wet[n] + change[n]);
      z[n] += change[n];
    }
    layer.steps_.push_back(std::move(step));
  }
  height = std::move(z);
  return layer;
}

}  // namespace firn::control::graph
