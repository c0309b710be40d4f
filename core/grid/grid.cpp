#include "core/grid/grid.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// Position in pitches; a cell centre is a whole number for any rounding of origin + i * pitch.
double cell_units(double x_mm, double origin_mm, double pitch_mm) {
  const double u = (x_mm - origin_mm) / pitch_mm, whole = std::floor(u + 0.5);
  return std::abs(u - whole) < 1e-9 * (1.0 + std::abs(whole)) ? whole : u;
}

}  // namespace

void check(const GridSpec& s) { check_options("grid", kGridSpec, s); }

std::int64_t DropletPattern::total() const {
  std::int64_t sum = 0;
  for (auto c : cells) sum += c;
  return sum;
}

int DropletPattern::passes() const {
  return cells.empty() ? 0 : *std::max_element(cells.begin(), cells.end());
}

std::int64_t Mask::count() const { return std::count(cells.begin(), cells.end(), std::uint8_t{1}); }

ErrorStats error_stats(const HeightMap& height, const HeightMap& target, const Mask& mask) {
  if (height.size() != target.size() || height.size() != mask.size())
    throw std::invalid_argument("error_stats: height, target and mask differ in size");
  ErrorStats s;
  double sum = 0.0, sum_abs = 0.0, sum_sq = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask.cells[c]) continue;
    const double e = height.cells[c] - target.cells[c];
    if (!std::isfinite(e)) {
      ++s.missing;
      continue;
    }
    s.min_mm = s.cells ? std::min(s.min_mm, e) : e;
    s.max_mm = s.cells ? std::max(s.max_mm, e) : e;
    ++s.cells;
    sum += e;
    sum_abs += std::abs(e);
    sum_sq += e * e;
  }
  if (!s.cells) return s;
  const double n = double(s.cells);
  s.mean_mm = sum / n;
  s.mean_abs_mm = sum_abs / n;
  s.rms_mm = std::sqrt(sum_sq / n);
  double var = 0.0;  // second pass: no cancellation
  for (std::size_t c = 0; c < height.size(); ++c) {
    const double e = height.cells[c] - target.cells[c];
    if (mask.cells[c] && std::isfinite(e)) var += (e - s.mean_mm) * (e - s.mean_mm);
  }
  s.std_mm = std::sqrt(var / n);
  return s;
}

HeightMap resample(const HeightMap& from, const GridSpec& to, double outside) {
  check(to);
  HeightMap out(to, outside);
  const GridSpec& f = from.spec;
  for (int j = 0; j < to.ny; ++j) {
    const double v = cell_units(to.y_mm(j), f.origin_y_mm, f.pitch_y_mm);
    if (v < 0.0 || v > f.ny - 1) continue;
    const int j0 = std::min(int(v), std::max(0, f.ny - 2));
    const double b = v - j0;
    for (int i = 0; i < to.nx; ++i) {
      const double u = cell_units(to.x_mm(i), f.origin_x_mm, f.pitch_x_mm);
      if (u < 0.0 || u > f.nx - 1) continue;
      const int i0 = std::min(int(u), std::max(0, f.nx - 2));
      const double a = u - i0;
      double sum = 0.0;
      const double w[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
      for (int q = 0; q < 4; ++q)
        if (w[q] != 0.0) sum += w[q] * from.at(i0 + (q & 1), j0 + (q >> 1));
      out.at(i, j) = sum;
    }
  }
  return out;
}

}  // namespace firn
