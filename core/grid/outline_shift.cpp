#include "core/grid/outline_shift.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace firn {
namespace {

constexpr std::size_t kFewCells = 12;
constexpr double kMinShare = 0.02;  // of the looked-at cells that must lie on either side of the outline

struct Near {
  int i, j;
  double rise_mm;
};

// Cells from which a shift within reach can move the outline away.
std::vector<Near> near_outline(const HeightMap& rise, const Mask& laid, int reach_x, int reach_y) {
  const GridSpec& g = laid.spec;
  // Cells of the mask in each rectangle from the low corner: a window's count in four additions.
  std::vector<std::int64_t> sums(std::size_t(g.nx + 1) * std::size_t(g.ny + 1), 0);
  const auto sum = [&](int i, int j) -> std::int64_t& {
    return sums[std::size_t(j) * std::size_t(g.nx + 1) + std::size_t(i)];
  };
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      sum(i + 1, j + 1) = sum(i, j + 1) + sum(i + 1, j) - sum(i, j) + (laid.at(i, j) ? 1 : 0);
  std::vector<Near> cells;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double z = rise.at(i, j);
      if (!std::isfinite(z)) continue;
      const int x0 = std::max(0, i - reach_x), x1 = std::min(g.nx, i + reach_x + 1),
                y0 = std::max(0, j - reach_y), y1 = std::min(g.ny, j + reach_y + 1);
      const std::int64_t in = sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0);
      const bool beyond = i < reach_x || j < reach_y || i + reach_x >= g.nx || j + reach_y >= g.ny;
      if (in == 0 || (!beyond && in == std::int64_t(x1 - x0) * (y1 - y0))) continue;
      cells.push_back({i, j, z});
    }
  return cells;
}

class Residuals {
 public:
  Residuals(const std::vector<Near>& cells, const Mask& laid, const Mask& beside)
      : cells_(cells), laid_(laid) {
    for (const Near& c : cells_) {
      square_ += c.rise_mm * c.rise_mm;
      beside_.push_back(beside.size() != 0 && beside.at(c.i, c.j) ? 1.0 : 0.0);
    }
  }
  struct Fit {
    double residual, rise_mm;
    std::size_t covered;
  };
  Fit at(int sx, int sy) const {
    double aa = 0.0, ab = 0.0, bb = 0.0, ra = 0.0, rb = 0.0;
    for (std::size_t n = 0; n < cells_.size(); ++n) {
      const Near& c = cells_[n];
      const int i = c.i - sx, j = c.j - sy;
      const double a = laid_.spec.contains(i, j) && laid_.at(i, j) ? 1.0 : 0.0, b = beside_[n];
      aa += a;
      ab += a * b;
      bb += b;
      ra += a * c.rise_mm;
      rb += b * c.rise_mm;
    }
    const std::size_t covered = std::size_t(aa);
    const double det = aa * bb - ab * ab;
    if (!(det > 0.0)) {  // one of the two covers nothing, or both the same
      const double h = aa > 0.0 ? std::max(0.0, ra / aa) : 0.0;
      return {square_ - h * ra, h, covered};
    }
    const double h = (ra * bb - rb * ab) / det, k = (rb * aa - ra * ab) / det;
    if (h <= 0.0) return {square_, 0.0, covered};
    return {square_ - h * ra - k * rb, h, covered};
  }

 private:
  const std::vector<Near>& cells_;
  const Mask& laid_;
  std::vector<double> beside_;
  double square_ = 0.0;
};

// Offset of the minimum of a parabola through three values one step apart.
double vertex(double below, double at, double above) {
  const double bend = below - 2.0 * at + above;
  return bend > 0.0 ? std::clamp(0.5 * (below - above) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace

OutlineShift outline_shift(const HeightMap& rise, const Mask& laid, const Mask& beside, double reach_mm) {
  const GridSpec& g = laid.spec;
  if (rise.spec != g || (beside.size() != 0 && beside.spec != g))
    throw std::invalid_argument("outline_shift: rise, laid and beside differ in size");
  const int rx = std::max(1, int(std::ceil(reach_mm / g.pitch_x_mm))),
            ry = std::max(1, int(std::ceil(reach_mm / g.pitch_y_mm)));
  const std::vector<Near> cells = near_outline(rise, laid, rx, ry);
  OutlineShift found;
  if (cells.size() < kFewCells) return found;
  const Residuals residuals(cells, laid, beside);
  const Residuals::Fit none = residuals.at(0, 0);
  Residuals::Fit best = none;
  int bx = 0, by = 0;
  for (int y = -ry; y <= ry; ++y)
    for (int x = -rx; x <= rx; ++x) {
      const Residuals::Fit f = residuals.at(x, y);
      const bool nearer = x * x + y * y < bx * bx + by * by;
      if (f.residual < best.residual || (f.residual == best.residual && nearer)) {
        best = f;
        bx = x;
        by = y;
      }
    }
  const double share = double(best.covered) / double(cells.size());
  if (!(best.rise_mm > 0.0) || share < kMinShare || share > 1.0 - kMinShare) return found;
  found.known = true;
  found.rise_mm = best.rise_mm;
  found.gain = none.residual > 0.0 ? 1.0 - std::max(0.0, best.residual) / none.residual : 0.0;
  found.x_mm = g.pitch_x_mm * (bx + vertex(residuals.at(bx - 1, by).residual, best.residual,
                                           residuals.at(bx + 1, by).residual));
  found.y_mm = g.pitch_y_mm * (by + vertex(residuals.at(bx, by - 1).residual, best.residual,
                                           residuals.at(bx, by + 1).residual));
  return found;
}

EdgeGap edge_gap(const HeightMap& rise) {
  const GridSpec& g = rise.spec;
  const auto measured = [&](int i, int j) { return g.contains(i, j) && std::isfinite(rise.at(i, j)); };
  struct Edge {
    double n = 0.0, sum = 0.0, squares = 0.0;
    void add(double z) {
      n += 1.0;
      sum += z;
      squares += z * z;
    }
    double mean() const { return sum / n; }
    double variance_of_mean() const { return std::max(0.0, squares / n - mean() * mean()) / n; }
  };
  Edge all, low[2], high[2];
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (!measured(i, j)) continue;
      const double z = rise.at(i, j);
      all.add(z);
      for (const int axis : {0, 1}) {
        const int dx = axis == 0, dy = axis == 1;
        const bool below = measured(i - dx, j - dy), above = measured(i + dx, j + dy);
        if (below && !above) high[axis].add(z);
        if (above && !below) low[axis].add(z);
      }
    }
  EdgeGap gap;
  if (!(all.sum > 0.0)) return gap;
  double* const value[] = {&gap.x_mm, &gap.y_mm};
  double* const error[] = {&gap.x_std_mm, &gap.y_std_mm};
  const double pitch[] = {g.pitch_x_mm, g.pitch_y_mm};
  gap.known = true;
  for (const int axis : {0, 1}) {
    if (low[axis].n < kFewCells || high[axis].n < kFewCells) {
      gap.known = false;
      continue;
    }
    const double per_mm = pitch[axis] / all.mean();
    *value[axis] = (low[axis].mean() - high[axis].mean()) * per_mm;
    *error[axis] = std::sqrt(low[axis].variance_of_mean() + high[axis].variance_of_mean()) * per_mm;
  }
  return gap;
}

}  // namespace firn
