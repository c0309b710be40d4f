#include "core/control/mpc/layer/layer_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/deposition/height_change.h"

namespace firn::control::mpc {

LayerProblem::LayerProblem(const Setup& s, const HeightMap& height, const MaterialMap& materials)
    : nx_(s.grid.nx), ny_(s.grid.ny), row_(whole_blocks(std::size_t(s.grid.nx)) + 2) {
  const std::size_t n = row_ * (std::size_t(ny_) + 2);
  const float inf = std::numeric_limits<float>::infinity();
  height_.assign(n, s.border == deposition::Border::kLose ? -inf : inf);
  bare_.assign(n, 0.0f);
  counts_.assign(n, 0);
  drops_.assign(n, 0);
  if (materials.size() != 0) inks_of_.assign(n, 0);
  for (const Material m : {Material::kA, Material::kB}) {
    Ink& ink = inks_[m == Material::kB];
    ink.drop_mm = float(s.model_of(m).layer_height_mm());
    for (const deposition::Link& link : deposition::links_of(deposition::stencil_of(s.model_of(m)))) {
      const std::size_t q = std::size_t((link.dy + 1) * 3 + link.dx + 1);
      ink.w_mm[q] = float(link.w_mm);
      ink.slope[q] = float(link.slope);
    }
  }
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
      const std::size_t c = s.grid.index(i, j), p = at(i, j);
      height_[p] = float(height.cells[c]);
      if (!inks_of_.empty()) inks_of_[p] = materials.of(c) == Material::kB;
      if (!s.mask.cells[c]) continue;
      counts_[p] = 1;
      bare_[p] = float(height.cells[c] - s.target.cells[c]);
      ++counted_;
    }
  error_ = bare_;
}

LayerProblem::Effect LayerProblem::effect(int i, int j) const {
  Effect e{};
  const std::size_t p = at(i, j);
  const Ink& ink = inks_[inks_of_.empty() ? 0 : inks_of_[p]];
  float own = ink.drop_mm;
  std::size_t q = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx, ++q) {
      if (q == 4) continue;
      const std::size_t to = std::size_t(std::ptrdiff_t(p) + dy * std::ptrdiff_t(row_) + dx);
      const float w = ink.w_mm[q];
      float f = w + ink.slope[q] * (height_[p] - height_[to]);
      f = f < w ? f : w;
      f = f > 0.0f ? f : 0.0f;
      own -= f;
      e[q] = counts_[to] ? f : 0.0f;
    }
  e[4] = counts_[p] ? own : 0.0f;
  return e;
}

float LayerProblem::outside_mm(int i, int j) const {
  const Effect e = effect(i, j);
  float counted = 0.0f;
  for (const float f : e) counted += f;
  const Ink& ink = inks_[inks_of_.empty() ? 0 : inks_of_[at(i, j)]];
  bool edge = false;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) edge = edge || counts_[at(i + dx, j + dy)] == 0;
  return edge ? std::max(0.0f, ink.drop_mm - counted) : 0.0f;
}

void LayerProblem::effects(int j, float* out) const {
  const std::size_t n = std::size_t(nx_);
  if (!inks_of_.empty()) {
    for (int i = 0; i < nx_; ++i) {
      const Effect e = effect(i, j);
      for (std::size_t q = 0; q < e.size(); ++q) out[q * n + std::size_t(i)] = e[q];
    }
    return;
  }
  const float* h = height_.data() + at(0, j);
  const std::uint8_t* counts = counts_.data() + at(0, j);
  const Ink& ink = inks_[0];
  float* own = out + 4 * n;
  for (std::size_t i = 0; i < n; ++i) own[i] = ink.drop_mm;
  std::size_t q = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx, ++q) {
      if (q == 4) continue;
      const std::ptrdiff_t to = dy * std::ptrdiff_t(row_) + dx;
      const float* there = h + to;
      const std::uint8_t* counted = counts + to;
      float* __restrict f = out + q * n;
      float* __restrict rest = own;
      const float w = ink.w_mm[q], slope = ink.slope[q];
      for (std::size_t i = 0; i < n; ++i) {
        float x = w + slope * (h[i] - there[i]);
        x = x < w ? x : w;
        x = x > 0.0f ? x : 0.0f;
        rest[i] -= x;
        f[i] = counted[i] ? x : 0.0f;
      }
    }
  for (std::size_t i = 0; i < n; ++i) own[i] = counts[i] ? own[i] : 0.0f;
}

void LayerProblem::set_drop(int i, int j, std::uint8_t drop) {
  const std::size_t p = at(i, j);
  if (drops_[p] == drop) return;
  drops_[p] = drop;
  const Effect e = effect(i, j);
  const float sign = drop ? 1.0f : -1.0f;
  std::size_t q = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx, ++q)
      error_[std::size_t(std::ptrdiff_t(p) + dy * std::ptrdiff_t(row_) + dx)] += sign * e[q];
}

void LayerProblem::set_drops(const DropletPattern& drops) {
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) drops_[at(i, j)] = printable(i, j) && drops.at(i, j) != 0;
  refresh();
}

DropletPattern LayerProblem::drops(const GridSpec& grid) const {
  DropletPattern u(grid);
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) u.at(i, j) = drop(i, j);
  return u;
}

void LayerProblem::clear() {
  std::fill(drops_.begin(), drops_.end(), std::uint8_t{0});
  error_ = bare_;
}

double LayerProblem::total_mm() const {
  double sum = 0.0;
  for (int j = 0; j < ny_; ++j) {
    const float* e = error_row(j);
    for (int i = 0; i < nx_; ++i) sum += std::abs(double(e[i]));
  }
  return sum;
}

}  // namespace firn::control::mpc
