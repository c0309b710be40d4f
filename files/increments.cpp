#include "files/increments.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

// A row with at least one value.
void fill_row(double* row, int nx) {
  int before = -1;  // last known cell
  for (int i = 0; i < nx; ++i) {
    if (std::isnan(row[i])) continue;
    for (int gap = before + 1; gap < i; ++gap)
      row[gap] = before < 0 ? row[i] : row[before] + (row[i] - row[before]) * (gap - before) / (i - before);
    before = i;
  }
  for (int i = before + 1; i < nx; ++i) row[i] = row[before];
}

// Layers without any increment between two that have some, once these are filled.
void fill_layers(std::vector<HeightMap>& increments, int first, int last) {
  int before = first;
  for (int k = first + 1; k <= last; ++k) {
    if (!has_value(increments[std::size_t(k)])) continue;
    const auto& low = increments[std::size_t(before)].cells;
    const auto& high = increments[std::size_t(k)].cells;
    for (int gap = before + 1; gap < k; ++gap)
      for (std::size_t c = 0; c < low.size(); ++c)
        increments[std::size_t(gap)].cells[c] = low[c] + (high[c] - low[c]) * (gap - before) / (k - before);
    before = k;
  }
}

}  // namespace

bool has_value(const Grid<double>& values) {
  return std::ranges::any_of(values.cells, [](double v) { return !std::isnan(v); });
}

std::optional<int> base_layer(const std::vector<HeightMap>& increments) {
  const auto first = std::ranges::find_if(increments, has_value);
  if (first == increments.end()) return std::nullopt;
  return std::max(0, int(first - increments.begin()) - 1);
}

void fill_along_x(Grid<double>& values) {
  double sum = 0.0;
  std::int64_t known = 0;
  for (const double v : values.cells) {
    if (std::isnan(v)) continue;
    sum += v;
    ++known;
  }
  if (known == 0) return;
  const int nx = values.spec.nx;
  for (int j = 0; j < values.spec.ny; ++j) {
    double* const row = values.cells.data() + values.spec.index(0, j);
    if (std::any_of(row, row + nx, [](double v) { return !std::isnan(v); }))
      fill_row(row, nx);
    else
      std::fill(row, row + nx, sum / double(known));
  }
}

IntegratedHeights integrate_increments(std::vector<HeightMap> increments, const HeightMap& ground) {
  IntegratedHeights out;
  out.base = base_layer(increments).value();
  const std::size_t layers = increments.size(), base = std::size_t(out.base);
  const GridSpec grid = increments.front().spec;
  std::vector<int> last(grid.size(), -1);  // layer of the cell's last increment
  for (std::size_t k = 0; k < layers; ++k) {
    Mask& mark = out.bridged.emplace_back(grid);
    for (std::size_t c = 0; c < grid.size(); ++c) {
      mark.cells[c] = std::isnan(increments[k].cells[c]);
      if (!mark.cells[c]) last[c] = int(k);
    }
  }
  const int end = *std::ranges::max_element(last);
  for (HeightMap& layer : increments) fill_along_x(layer);
  // Of a record that begins at layer 0, its increments are the ground.
  const bool begins = has_value(increments[base]);
  if (!begins) increments[base].cells.assign(grid.size(), 0.0);
  fill_layers(increments, begins ? out.base : out.base + 1, end);
  for (std::size_t k = 0; k < layers; ++k) {
    HeightMap& height = out.heights.emplace_back(increments[k]);
    for (std::size_t c = 0; c < grid.size(); ++c) {
      std::uint8_t& mark = out.bridged[k].cells[c];
      if (k <= base && !begins) {
        height.cells[c] = ground.cells[c];
        mark = k > 0;
        continue;
      }
      if (int(k) > last[c]) {
        height.cells[c] = kNotMeasured;
        mark = 0;
        continue;
      }
      if (k > 0) height.cells[c] += out.heights[k - 1].cells[c];
      out.bridges += mark;
    }
  }
  return out;
}

}  // namespace firn
