#include "core/control/mpc/horizon_state.h"

#include <algorithm>

#include "core/deposition/height_change.h"

namespace firn::control::mpc {
namespace {

// Ground beyond the border, so low that it takes every share or so high that it takes none; finite, so that
// differences stay numbers.
constexpr float kFar_mm = 1e3f;

float given(float gives, float slope, float drop) {
  float x = gives + slope * drop;
  x = x < gives ? x : gives;
  return x > 0.0f ? x : 0.0f;
}

// Flows from the cells of a row to their neighbours of one side, and back.
void exchange(const float* height, const float* gives, const float* slope, std::size_t here,
              std::size_t there, std::size_t n, float* __restrict own, float* __restrict in) {
  for (std::size_t i = 0; i < n; ++i) {
    own[i] -= given(gives[here + i], slope[here + i], height[here + i] - height[there + i]);
    in[i] += given(gives[there + i], slope[there + i], height[there + i] - height[here + i]);
  }
}

}  // namespace

HorizonState::HorizonState(const Setup& s, const HeightMap& height, std::span<const MaterialMap> materials,
                           int horizon, const PlanCost& cost)
    : nx(std::uint32_t(s.grid.nx)),
      ny(std::uint32_t(s.grid.ny)),
      row(nx + 2 * kMargin),
      layers(std::size_t(horizon)) {
  const std::size_t n = row * (ny + 2 * kMargin);
  for (const Material m : {Material::kA, Material::kB}) {
    const deposition::DropletModel& d = s.model_of(m);
    const double w[2] = {d.h2_mm, d.h3_mm};
    Ink& to = ink[m == Material::kB];
    to.drop_mm = float(d.layer_height_mm());
    for (int k = 0; k < 2; ++k) {
      to.gives_mm[k] = float(w[k]);
      to.slope[k] = float(w[k] / (d.h1_mm + w[k]));
    }
  }
  const float far = s.border == deposition::Border::kLose ? -kFar_mm : kFar_mm;
  error_mm.assign(n, 0.0f);
  counts.assign(n, 0.0f);
  target_.assign(n, 0.0f);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    Layer& l = layers[k];
    l.height_mm.assign(n, far);
    l.drops.assign(n, 0);
    l.inks.assign(n, 0);
    for (int c = 0; c < 2; ++c) {
      l.gives_mm[c].assign(n, 0.0f);
      l.slope[c].assign(n, 0.0f);
    }
    if (k < materials.size() && materials[k].size() != 0)
      for (std::uint32_t c = 0; c < s.grid.size(); ++c) l.inks[at(c)] = materials[k].of(c) == Material::kB;
  }
  for (std::uint32_t c = 0; c < s.grid.size(); ++c) {
    layers[0].height_mm[at(c)] = float(height.cells[c]);
    if (!s.mask.cells[c]) continue;
    counts[at(c)] = 1.0f;
    target_[at(c)] = float(s.target.cells[c]);
    cells += 1.0;
  }
  if (cost.outside_price > 0.0) price_outside(s, cost);
}

void HorizonState::price_outside(const Setup& s, const PlanCost& cost) {
  const bool square = cost.error == ErrorKind::kSquare;
  if (square) outside_price_mm_ = cost.outside_price * s.model.layer_height_mm();
  outside_error_mm_ = square ? kOutsideSquare_mm : kOutside_mm * float(std::max(1.0, cost.outside_price));
  const float counted =
      float(square ? cost.outside_price * s.model.layer_height_mm() / (2.0 * double(kOutsideSquare_mm))
                   : cost.outside_price);
  part_.assign(counts.size(), 0);
  for (std::uint32_t c = 0; c < s.grid.size(); ++c) part_[at(c)] = s.mask.cells[c] != 0;
  const std::size_t first =
      at(0) - row - 1;  // the cells of the grid and a ring, into which a border may lose
  for (std::size_t j = 0; j < ny + 2; ++j)
    for (std::size_t i = 0; i < nx + 2; ++i) {
      const std::size_t p = first + j * row + i;
      if (part_[p]) continue;
      counts[p] = counted;
      error_mm[p] = outside_error_mm_;
      if (i > 0 && i <= nx && j > 0 && j <= ny) target_[p] = layers[0].height_mm[p];
    }
}

void HorizonState::set_drop(int layer, std::size_t p, std::uint8_t drop) {
  Layer& l = layers[std::size_t(layer)];
  l.drops[p] = drop;
  for (int k = 0; k < 2; ++k) {
    l.gives_mm[k][p] = drop ? ink[l.inks[p]].gives_mm[k] : 0.0f;
    l.slope[k][p] = drop ? ink[l.inks[p]].slope[k] : 0.0f;
  }
}

void HorizonState::set_drops(std::span<const DropletPattern> plan) {
  for (int k = 0; k < horizon(); ++k)
    for (std::uint32_t c = 0; c < nx * ny; ++c) set_drop(k, at(c), plan[std::size_t(k)].cells[c]);
}

void HorizonState::set_plan(std::span<const DropletPattern> plan) {
  set_drops(plan);
  refresh();
}

std::vector<DropletPattern> HorizonState::plan(const GridSpec& grid) const {
  std::vector<DropletPattern> out(layers.size(), DropletPattern(grid));
  for (std::size_t k = 0; k < out.size(); ++k)
    for (std::uint32_t c = 0; c < nx * ny; ++c) out[k].cells[c] = layers[k].drops[at(c)];
  return out;
}

// All height that the droplets bring but what the part's cells have of it: their large errors hold no single
// droplet.
double HorizonState::outside_mm2() const {
  if (outside_price_mm_ == 0.0) return 0.0;
  double beside_mm = 0.0;
  for (const Layer& l : layers)
    for (std::size_t p = 0; p < l.drops.size(); ++p)
      if (l.drops[p]) beside_mm += double(ink[l.inks[p]].drop_mm);
  for (std::size_t p = 0; p < part_.size(); ++p)
    if (part_[p]) beside_mm -= double(error_mm[p]) + double(target_[p]) - double(layers[0].height_mm[p]);
  return outside_price_mm_ * beside_mm;
}

void HorizonState::refresh() {
  std::vector<float> own(nx), in(nx);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const Layer& l = layers[k];
    const bool last = k + 1 == layers.size();
    for (std::uint32_t j = 0; j < ny; ++j) {
      const std::size_t first = at(j * nx);
      for (std::uint32_t i = 0; i < nx; ++i) {
        own[i] = l.drops[first + i] ? ink[l.inks[first + i]].drop_mm : 0.0f;
        in[i] = 0.0f;
      }
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx == 0 && dy == 0) continue;
          const std::size_t corner = dx != 0 && dy != 0,
                            there = std::size_t(std::ptrdiff_t(first) + dy * std::ptrdiff_t(row) + dx);
          exchange(l.height_mm.data(), l.gives_mm[corner].data(), l.slope[corner].data(), first, there, nx,
                   own.data(), in.data());
        }
      const float* h = l.height_mm.data() + first;
      if (!last) {
        float* after = layers[k + 1].height_mm.data() + first;
        for (std::uint32_t i = 0; i < nx; ++i) after[i] = h[i] + (own[i] + in[i]);
        continue;
      }
      for (std::uint32_t i = 0; i < nx; ++i)
        if (on_part(first + i) && counts[first + i] != 0.0f)
          error_mm[first + i] = (h[i] + (own[i] + in[i])) - target_[first + i];
        else if (counts[first + i] != 0.0f)
          error_mm[first + i] =
              outside_error_mm_ + counts[first + i] * ((h[i] + (own[i] + in[i])) - target_[first + i]);
    }
  }
  first_mm = second_mm2 = droplets = 0.0;
  for (const Layer& l : layers)
    for (const std::uint8_t u : l.drops) droplets += u;
  for (std::size_t p = 0; p < error_mm.size(); ++p) {
    if (!on_part(p)) continue;
    first_mm += double(error_mm[p]);
    second_mm2 += double(error_mm[p]) * double(error_mm[p]);
  }
  second_mm2 += outside_mm2();
}

}  // namespace firn::control::mpc
