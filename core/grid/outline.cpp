#include "core/grid/outline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>

#include "core/grid/edge_profile.h"

namespace firn {
namespace {

// A line of cells in a map: `count` values from `first` on, `step` apart.
struct Line {
  const double* first;
  std::size_t step;
  int count;
  double operator()(int i) const { return first[std::size_t(i) * step]; }
};

bool known(const Line& h, int i) { return i >= 0 && i < h.count && std::isfinite(h(i)); }

// Distance from cell `i`, which reaches the level, to the crossing towards cell `beyond` [pitches]: half a
// cell where nothing is known beyond.
double crossing(const Line& h, int i, int beyond, double level) {
  return known(h, beyond) ? (h(i) - level) / (h(i) - h(beyond)) : 0.5;
}

// Jaws that close on the level over all lines added [pitches].
struct Caliper {
  double low = INFINITY, high = -INFINITY;
  bool cut = false;
  void add(const Line& h, double level) {
    int first = -1, last = -1;
    for (int i = 0; i < h.count; ++i)
      if (h(i) >= level) {
        if (first < 0) first = i;
        last = i;
      }
    if (first < 0) return;
    low = std::min(low, first - crossing(h, first, first - 1, level));
    high = std::max(high, last + crossing(h, last, last + 1, level));
    cut = cut || !known(h, first - 1) || !known(h, last + 1);
  }
  double width() const { return high > low ? high - low : kNotMeasured; }
};

Caliper along_x(const HeightMap& h, double level) {
  Caliper jaws;
  for (int j = 0; j < h.spec.ny; ++j) jaws.add({h.data() + h.spec.index(0, j), 1, h.spec.nx}, level);
  return jaws;
}

Caliper along_y(const HeightMap& h, double level) {
  Caliper jaws;
  for (int i = 0; i < h.spec.nx; ++i) jaws.add({h.data() + i, std::size_t(h.spec.nx), h.spec.ny}, level);
  return jaws;
}

// Target and mask on the grid of a height map that holds theirs.
struct Placed {
  HeightMap target;
  Mask mask;
};

Placed placed(const GridSpec& on, const HeightMap& target, const Mask& mask) {
  const GridSpec& g = target.spec;
  const int di = int(std::lround((g.origin_x_mm - on.origin_x_mm) / on.pitch_x_mm));
  const int dj = int(std::lround((g.origin_y_mm - on.origin_y_mm) / on.pitch_y_mm));
  if (mask.size() != target.size() || di < 0 || dj < 0 || di + g.nx > on.nx || dj + g.ny > on.ny)
    throw std::invalid_argument("outline_stats: height, target and mask do not fit each other");
  Placed out{HeightMap(on, 0.0), Mask(on)};
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      if (mask.at(i, j)) {
        out.target.at(i + di, j + dj) = target.at(i, j);
        out.mask.at(i + di, j + dj) = 1;
      }
  return out;
}

bool beside_part(const Mask& mask, int i, int j) {
  for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
    if (mask.spec.contains(i + di, j + dj) && mask.at(i + di, j + dj)) return true;
  return false;
}

// Every cell in `parts` x `parts`, as in a finer map.
template <class Cells>
Cells refined(const Cells& from, const GridSpec& to, int parts) {
  Cells out(to);
  for (int j = 0; j < to.ny; ++j)
    for (int i = 0; i < to.nx; ++i) out.at(i, j) = from.at(i / parts, j / parts);
  return out;
}

void add_rms(const HeightMap& height, const HeightMap& target, const Mask& mask, OutlineStats& s) {
  if (const ErrorStats whole = error_stats(height, target, mask); whole.cells > 0) s.rms_mm = whole.rms_mm;
  if (const ErrorStats in = error_stats(height, target, inside_of(mask)); in.cells > 0)
    s.rms_inside_mm = in.rms_mm;
}

void add_edge(const HeightMap& height, const HeightMap& target, const Mask& mask, const HeightMap* fine,
              OutlineStats& s) {
  if (!fine) {
    s.edge_width_mm = edge_width_mm(height, target, mask);
    s.corner_radius_mm = corner_radius_mm(height, target, mask);
    return;
  }
  const int parts = height.spec.nx > 0 ? fine->spec.nx / height.spec.nx : 0;
  if (parts < 1 || fine->spec.nx != parts * height.spec.nx || fine->spec.ny != parts * height.spec.ny)
    throw std::invalid_argument("outline_stats: the fine map does not cover the ground of the other");
  const HeightMap fine_target = refined(target, fine->spec, parts);
  const Mask fine_mask = refined(mask, fine->spec, parts);
  s.edge_width_mm = edge_width_mm(*fine, fine_target, fine_mask);
  s.corner_radius_mm = corner_radius_mm(*fine, fine_target, fine_mask, parts);
}

}  // namespace

const OutlineMetric& outline_metric(std::string_view name) {
  const auto* row = std::ranges::find(kOutlineMetrics, name, &OutlineMetric::name);
  if (row == std::end(kOutlineMetrics))
    throw std::invalid_argument("outline_metric: no value is called " + std::string(name));
  return *row;
}

OutlineStats outline_stats(const HeightMap& height, const HeightMap& target_there, const Mask& mask_there,
                           const HeightMap* fine) {
  const auto [target, mask] = placed(height.spec, target_there, mask_there);
  double inside = 0.0, outside = 0.0, missing = 0.0, ring = 0.0, highest = 0.0;
  std::int64_t cells = 0, ring_cells = 0, known_cells = 0;
  for (int j = 0; j < mask.spec.ny; ++j)
    for (int i = 0; i < mask.spec.nx; ++i) {
      const double h = height.at(i, j);
      if (mask.at(i, j)) {
        inside += target.at(i, j);
        if (std::isfinite(h)) {
          missing += std::max(0.0, target.at(i, j) - h);
          ++known_cells;
        }
        highest = std::max(highest, target.at(i, j));
      } else if (std::isfinite(h)) {
        outside += h;
        ++cells;
        if (beside_part(mask, i, j)) {
          ring += h;
          ++ring_cells;
        }
      }
    }
  OutlineStats s;
  if (cells > 0 && inside > 0.0) s.overspill = outside / inside;
  if (known_cells > 0 && inside > 0.0) s.missing = missing / inside;
  s.misplaced = s.overspill + s.missing;
  if (ring_cells > 0) s.first_ring_mm = ring / double(ring_cells);
  add_rms(height, target, mask, s);
  if (highest <= 0.0) return s;
  add_edge(height, target, mask, fine, s);
  const double level = 0.5 * highest;
  const Caliper x = along_x(height, level), y = along_y(height, level);
  s.size_error_x_mm = (x.width() - along_x(target, level).width()) * height.spec.pitch_x_mm;
  s.size_error_y_mm = (y.width() - along_y(target, level).width()) * height.spec.pitch_y_mm;
  s.cut = x.cut || y.cut;
  return s;
}

std::array<double, 3> part_size_mm(const HeightMap& target, const Mask& mask) {
  const GridSpec& g = mask.spec;
  int x0 = g.nx, x1 = -1, y0 = g.ny, y1 = -1;
  double top = 0.0;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (!mask.at(i, j)) continue;
      x0 = std::min(x0, i);
      x1 = std::max(x1, i);
      y0 = std::min(y0, j);
      y1 = std::max(y1, j);
      top = std::max(top, target.at(i, j));
    }
  return {std::max(0, x1 - x0 + 1) * g.pitch_x_mm, std::max(0, y1 - y0 + 1) * g.pitch_y_mm, top};
}

Mask inside_of(const Mask& mask) {
  const GridSpec& g = mask.spec;
  Mask inside(g);
  for (int j = 1; j + 1 < g.ny; ++j)
    for (int i = 1; i + 1 < g.nx; ++i) {
      bool all = true;
      for (int y = j - 1; y <= j + 1; ++y)
        for (int x = i - 1; x <= i + 1; ++x) all = all && mask.at(x, y);
      inside.at(i, j) = all;
    }
  return inside;
}

}  // namespace firn
