#include "estimators/droplet/surface_filter.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/options/require.h"

namespace firn::droplet {
namespace {

// Sides first, then corners.
constexpr int kDx[8] = {1, -1, 0, 0, 1, -1, 1, -1};
constexpr int kDy[8] = {0, 0, 1, -1, 1, 1, -1, -1};

}  // namespace

void check_map(std::string_view where, const GridSpec& grid, const HeightMap& height,
               const std::vector<Use>& use, double noise_std_mm) {
  require(height.size() == grid.size() && use.size() == grid.size(), where,
          "the map does not have the grid's size");
  require(noise_std_mm > 0.0 && std::isfinite(noise_std_mm), where,
          "noise_std_mm = " + std::to_string(noise_std_mm) + " must be above 0");
  for (std::size_t c = 0; c < use.size(); ++c)
    require(use[c] == Use::kNothing || std::isfinite(height.cells[c]), where,
            "cell " + std::to_string(c) + " has no height and is not marked so");
}

SurfaceFilter::SurfaceFilter(const GridSpec& grid, deposition::Border border)
    : grid_(grid),
      border_(border),
      inner_(grid.size(), 0),
      change_(grid.size(), 0.0),
      own_(grid.size(), 0.0),
      from_(grid.size(), 0.0) {
  for (int j = 1; j + 1 < grid.ny; ++j)
    for (int i = 1; i + 1 < grid.nx; ++i) inner_[grid.index(i, j)] = 1;
  for (int n = 0; n < 8; ++n) offset_[std::size_t(n)] = std::ptrdiff_t(kDy[n]) * grid.nx + kDx[n];
}

Surface SurfaceFilter::substrate(std::span<const double> z, std::span<const Use> use,
                                 double noise_variance) const {
  // Plane a + b x + c y about the grid's middle: on a full grid its normal equations are diagonal, and with a
  // few cells missing nearly so; three rounds of the diagonal solution bring the rest.
  const double mid_x = 0.5 * (grid_.nx - 1), mid_y = 0.5 * (grid_.ny - 1);
  double a = 0.0, b = 0.0, c = 0.0, spread = 0.0, n = 0.0;
  for (int round = 0; round < 4; ++round) {
    double s1 = 0.0, sx = 0.0, sy = 0.0, xx = 0.0, yy = 0.0;
    n = spread = 0.0;
    for (std::size_t cell = 0; cell < z.size(); ++cell) {
      if (use[cell] == Use::kNothing) continue;
      const double x = double(cell % std::size_t(grid_.nx)) - mid_x,
                   y = double(cell / std::size_t(grid_.nx)) - mid_y;
      const double r = z[cell] - (a + b * x + c * y);
      n += 1.0;
      s1 += r;
      sx += r * x;
      sy += r * y;
      xx += x * x;
      yy += y * y;
      spread += r * r;
    }
    if (round == 3 || n < 1.0) break;
    a += s1 / n;
    if (xx > 0.0) b += sx / xx;
    if (yy > 0.0) c += sy / yy;
  }
  // Hills are assumed only where the spread exceeds that of noise alone (three standard errors).
  const double variance = n > 3.0 ? spread / (n - 3.0) : 0.0;
  const double rough = n > 3.0 && variance > noise_variance * (1.0 + 3.0 * std::sqrt(2.0 / n))
                           ? variance - noise_variance
                           : 0.0;
  const double gain = rough > 0.0 ? rough / (rough + noise_variance) : 0.0;
  Surface s{std::vector<double>(z.size()), std::vector<double>(z.size())};
  for (std::size_t cell = 0; cell < z.size(); ++cell) {
    const double x = double(cell % std::size_t(grid_.nx)) - mid_x,
                 y = double(cell / std::size_t(grid_.nx)) - mid_y;
    const double plane = a + b * x + c * y;
    const double g = use[cell] == Use::kNothing ? 0.0 : gain;
    s.height_mm[cell] = plane + (use[cell] == Use::kNothing ? 0.0 : g * (z[cell] - plane));
    s.variance_mm2[cell] = (1.0 - g) * rough;
  }
  return s;
}

SurfaceFilter::Links SurfaceFilter::links_of(const deposition::DropletModel& m, double scatter) const {
  Links links;
  for (int n = 0; n < 8; ++n) {
    const double w = n < 4 ? m.h2_mm : m.h3_mm, reach = m.h1_mm + w;
    links[std::size_t(n)] = {w, w / reach, reach, scatter * scatter * reach * reach};
  }
  return links;
}

std::uint32_t SurfaceFilter::neighbour(std::uint32_t cell, int n) const {
  if (!inner_[cell]) {
    const int i = int(cell) % grid_.nx + kDx[n], j = int(cell) / grid_.nx + kDy[n];
    if (!grid_.contains(i, j)) return cell;
  }
  return std::uint32_t(std::ptrdiff_t(cell) + offset_[std::size_t(n)]);
}

void SurfaceFilter::exchange(const Pass& pass, std::span<const double> h, std::span<const double> variance,
                             const Links& links, bool sensitive) {
  const std::size_t count = pass.cells.size();
  droplets_ = count + count % 2;
  const std::size_t links_of_pass = 8 * droplets_;  // the workspace only grows: all of them are written below
  if (give_mm_.size() < links_of_pass) give_mm_.resize(links_of_pass);
  if (sensitive && sensitivity_.size() < links_of_pass) sensitivity_.resize(links_of_pass);
  for (int n = 0; n < 8; ++n) {
    const SoftLink& link = links[std::size_t(n)];
    double* const give = give_mm_.data() + std::size_t(n) * droplets_;
    double* const k = sensitivity_.data() + (sensitive ? std::size_t(n) * droplets_ : 0);
    const std::ptrdiff_t offset = offset_[std::size_t(n)];
    for (std::size_t at = 0; at < count; at += 2) {
      const std::uint32_t a = pass.cells[at], b = pass.cells[at + 1 < count ? at + 1 : at];
      const std::size_t to_a = inner_[a] ? std::size_t(a) + std::size_t(offset) : neighbour(a, n);
      const std::size_t to_b = inner_[b] ? std::size_t(b) + std::size_t(offset) : neighbour(b, n);
      const Two d{h[a] - h[to_a], h[b] - h[to_b]},
          v{variance[a] + variance[to_a], variance[b] + variance[to_b]};
      _mm_storeu_pd(give + at, link.spread_mm(d, v));
      if (sensitive) _mm_storeu_pd(k + at, link.sensitivity(d, v));
    }
  }
}

void SurfaceFilter::settle(const Pass& pass, std::vector<double>& h, const Links& links, double drop_mm) {
  std::fill(change_.begin(), change_.end(), 0.0);
  for (std::size_t at = 0; at < pass.cells.size(); ++at) {
    const std::uint32_t c = pass.cells[at];
    double own = drop_mm;
    const double* give_mm = give_mm_.data() + at;
    if (inner_[c]) {
      for (std::size_t n = 0; n < 8; ++n) {
        const double give = give_mm[n * droplets_];
        own -= give;
        change_[c + std::size_t(offset_[n])] += give;
      }
      change_[c] += own;
      continue;
    }
    for (int n = 0; n < 8; ++n) {
      if (!on_grid(c, n)) {
        own -= border_ == deposition::Border::kLose ? links[std::size_t(n)].w_mm : 0.0;
        continue;
      }
      const double give = give_mm[std::size_t(n) * droplets_];
      own -= give;
      change_[neighbour(c, n)] += give;
    }
    change_[c] += own;
  }
  for (std::size_t c = 0; c < h.size(); ++c) h[c] += pass.share * change_[c];
}

void SurfaceFilter::predict(Layer& layer, Surface& s, const deposition::DropletModel& model, double scatter) {
  const Links links = links_of(model, scatter);
  const double drop_mm = model.layer_height_mm();
  layer.variance_mm2.assign(layer.passes.size(), {});
  layer.scatter_mm2.assign(grid_.size(), 0.0);
  for (std::size_t p = 0; p < layer.passes.size(); ++p) {
    const Pass& pass = layer.passes[p];
    layer.variance_mm2[p] = s.variance_mm2;
    // own_: the cell's own share of its error that is left; from_: variance that its neighbours' errors
    // bring.
    std::fill(own_.begin(), own_.end(), 1.0);
    std::fill(from_.begin(), from_.end(), 0.0);
    exchange(pass, s.height_mm, s.variance_mm2, links, true);
    for (std::size_t at = 0; at < pass.cells.size(); ++at) {
      const std::uint32_t c = pass.cells[at];
      double own_mm = drop_mm;
      for (int n = 0; n < 8; ++n) {
        if (!on_grid(c, n)) {
          own_mm -= border_ == deposition::Border::kLose ? links[std::size_t(n)].w_mm : 0.0;
          continue;
        }
        const std::uint32_t to = neighbour(c, n);
        const std::size_t link = std::size_t(n) * droplets_ + at;
        const double give = give_mm_[link], k = pass.share * sensitivity_[link];
        own_mm -= give;
        layer.scatter_mm2[to] += pass.share * give * give;
        own_[c] -= k;
        own_[to] -= k;
        from_[c] += k * k * s.variance_mm2[to];
        from_[to] += k * k * s.variance_mm2[c];
      }
      layer.scatter_mm2[c] += pass.share * own_mm * own_mm;
    }
    settle(pass, s.height_mm, links, drop_mm);
    for (std::size_t c = 0; c < grid_.size(); ++c)
      s.variance_mm2[c] = own_[c] * own_[c] * s.variance_mm2[c] + from_[c];
  }
  for (std::size_t c = 0; c < grid_.size(); ++c)
    s.variance_mm2[c] += scatter * scatter * layer.scatter_mm2[c];
}

void SurfaceFilter::reference(Layer& layer, Surface& s, const deposition::DropletModel& model,
                              double scatter) {
  predict(layer, s, model, scatter);
  layer.gain.assign(grid_.size(), 0.0);
  layer.weight.assign(grid_.size(), 0.0);
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    const double before = s.variance_mm2[c], total = before + layer.noise_variance_mm2;
    if (layer.use[c] == Use::kNothing) continue;
    if (layer.use[c] == Use::kAnchor) {
      layer.gain[c] = 1.0;
      s.height_mm[c] = layer.height_mm[c];
      s.variance_mm2[c] = layer.noise_variance_mm2;
      continue;
    }
    layer.weight[c] = 1.0 / total;
    layer.gain[c] = before / total;
    s.height_mm[c] += layer.gain[c] * (layer.height_mm[c] - s.height_mm[c]);
    s.variance_mm2[c] = (1.0 - layer.gain[c]) * before;
  }
}

void SurfaceFilter::differences(const Layer& layer, std::vector<double>& h,
                                const deposition::DropletModel& model, double scatter,
                                std::span<double> difference) {
  const Links links = links_of(model, scatter);
  const double drop_mm = model.layer_height_mm();
  for (std::size_t p = 0; p < layer.passes.size(); ++p) {
    exchange(layer.passes[p], h, layer.variance_mm2[p], links, false);
    settle(layer.passes[p], h, links, drop_mm);
  }
  for (std::size_t c = 0; c < h.size(); ++c) {
    difference[c] = 0.0;
    if (layer.use[c] == Use::kNothing) continue;
    const double e = layer.height_mm[c] - h[c];
    if (layer.use[c] == Use::kLearn) difference[c] = e;
    h[c] += layer.gain[c] * e;
  }
}

}  // namespace firn::droplet
