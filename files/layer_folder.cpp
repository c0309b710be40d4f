#include "files/layer_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <utility>

#include "core/grid/npy.h"
#include "files/increments.h"
#include "files/layer_file_names.h"
#include "files/layer_limits.h"
#include "files/matrix_labels.h"
#include "files/separated_values.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::map<int, fs::path> layer_files(const fs::path& folder, int layer_number) {
  if (!fs::is_directory(folder)) throw UsageError(folder.string() + ": no such folder");
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".npy" || ending == ".csv" || ending == ".txt") all.push_back(entry.path());
  }
  if (all.empty()) throw UsageError(folder.string() + ": no .npy, .csv or .txt file");
  std::ranges::sort(all);
  return layers_by_name(all, layer_number);
}

struct Matrix {
  std::vector<std::vector<double>> rows;
};

Matrix matrix_of(const fs::path& file, MatrixLabels labels, std::vector<std::string>& assumptions) {
  Matrix m;
  if (file.extension() != ".npy") {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw UsageError(file.string() + ": cannot be read");
    SeparatedValues table(in, file.string());
    std::vector<SeparatedRow> rows;
    for (SeparatedRow row; table.next(row);)
      if (!row.fields.empty()) rows.push_back(row);
    const LabelledEdges edges = labelled_edges(table, rows, labels);
    if (!edges.assumption.empty() && std::ranges::find(assumptions, edges.assumption) == assumptions.end())
      assumptions.push_back(edges.assumption);
    for (std::size_t j = edges.row ? 1 : 0; j < rows.size(); ++j) {
      std::vector<double>& out = m.rows.emplace_back();
      for (std::size_t f = edges.column ? 1 : 0; f < rows[j].fields.size(); ++f)
        out.push_back(table.number(rows[j], f, fmt::format("column {}", f + 1)));
    }
    return m;
  }
  const std::string text = read_file(file);
  try {
    const auto bytes = std::as_bytes(std::span(text));
    const NpyShape shape = npy_shape(bytes, file.string());
    const HeightMap map = height_map_from_npy(bytes, {shape.nx, shape.ny, 1, 1, 0, 0}, file.string());
    for (int j = 0; j < shape.ny; ++j)
      m.rows.emplace_back(map.cells.begin() + std::ptrdiff_t(map.spec.index(0, j)),
                          map.cells.begin() + std::ptrdiff_t(map.spec.index(0, j)) + shape.nx);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
  return m;
}

Grid<double> fitted(const Matrix& m, const GridSpec& grid, double scale) {
  Grid<double> g(grid, kUnmeasured);
  for (std::size_t j = 0; j < m.rows.size(); ++j)
    for (std::size_t i = 0; i < m.rows[j].size(); ++i)
      g.cells[grid.index(int(i), int(j))] = m.rows[j][i] * scale;
  return g;
}

void refuse_beyond(const fs::path& folder, int layer, const Grid<double>& grid, double limit,
                   const char* quantity) {
  for (const double v : grid.cells)
    if (std::abs(v) > limit)
      throw UsageError(
          fmt::format("{}: layer {}: {} {:g}, not within {:g}", folder.string(), layer, quantity, v, limit));
}

// The files of one quantity.
using LayerMatrices = std::map<int, Matrix>;

LayerMatrices matrices_of(const fs::path& folder, const LayerRecordOptions& o,
                          std::vector<std::string>& assumptions) {
  LayerMatrices all;
  if (folder.empty()) return all;
  for (const auto& [layer, file] : layer_files(folder, o.layer_number))
    all.emplace(layer, matrix_of(file, o.labels, assumptions));
  return all;
}

// A single number is of all cells.
std::vector<HeightMap> wanted_of(const fs::path& folder, const LayerMatrices& matrices, const GridSpec& grid,
                                 std::size_t layers, double scale) {
  std::vector<HeightMap> out(matrices.empty() ? 0 : layers, HeightMap(grid, kUnmeasured));
  for (const auto& [layer, m] : matrices) {
    if (std::size_t(layer) >= layers) continue;
    HeightMap& map = out[std::size_t(layer)];
    if (m.rows.size() == 1 && m.rows.front().size() == 1)
      std::ranges::fill(map.cells, m.rows.front().front() * scale);
    else
      map.cells = fitted(m, grid, scale).cells;
    refuse_beyond(folder, layer, map, kFarthest_mm, "a target or error [mm] of");
  }
  return out;
}

}  // namespace

LayerRecord read_layer_files(const LayerFolders& f, const LayerRecordOptions& o) {
  if (!f.inputs.empty() && !f.speeds.empty())
    throw UsageError(f.speeds.string() + ": input and speed are one input told twice");
  if (!f.targets.empty() && !f.errors.empty())
    throw UsageError(f.errors.string() + ": target and error tell one thing twice");
  LayerRecord r;
  r.input_is_speed = !f.speeds.empty();
  const fs::path& heights = f.heights;
  const fs::path& inputs = r.input_is_speed ? f.speeds : f.inputs;
  const fs::path& wanted = f.errors.empty() ? f.targets : f.errors;
  const LayerMatrices maps = matrices_of(heights, o, r.assumptions),
                      commands = matrices_of(inputs, o, r.assumptions),
                      goals = matrices_of(wanted, o, r.assumptions);
  std::size_t nx = 0, ny = 0;
  for (const auto* some : {&maps, &commands, &goals})
    for (const auto& [layer, m] : *some) {
      ny = std::max(ny, m.rows.size());
      for (const auto& row : m.rows) nx = std::max(nx, row.size());
    }
  if (nx == 0 || nx > kMaxGridSide || ny > kMaxGridSide)
    throw UsageError(heights.string() + ": " + std::to_string(nx) + " x " + std::to_string(ny) +
                     " cells, not within 1 to " + std::to_string(kMaxGridSide));
  const double scale = o.unit.empty() ? 1.0 : millimetres(o.unit, heights.string());
  if (o.unit.empty()) r.assumptions.push_back("heights have no unit: taken as mm (--unit)");
  if (o.pitch_x_mm <= 0) r.assumptions.push_back("cells have no size: taken as 1 mm (--pitch-mm)");
  const double pitch_x = o.pitch_x_mm > 0 ? o.pitch_x_mm : 1.0;
  r.grid = {int(nx), int(ny), pitch_x, o.pitch_y_mm > 0 ? o.pitch_y_mm : pitch_x, 0.0, 0.0};
  const int last = std::max(maps.rbegin()->first, commands.empty() ? 0 : commands.rbegin()->first);
  check_record_size(heights.string(), std::size_t(last) + 1, r.grid);
  r.heights.assign(std::size_t(last) + 1, HeightMap(r.grid, kUnmeasured));
  for (const auto& [layer, m] : maps) {
    HeightMap& map = r.heights[std::size_t(layer)];
    map.cells = fitted(m, r.grid, scale).cells;
    refuse_beyond(heights, layer, map, kFarthest_mm, "a height [mm] of");
  }
  if (!commands.empty()) {
    r.inputs.assign(std::size_t(last), Grid<double>(r.grid, kUnmeasured));
    for (const auto& [layer, m] : commands) {
      if (layer == 0) continue;
      Grid<double>& input = r.inputs[std::size_t(layer - 1)];
      input = fitted(m, r.grid, 1.0);
      refuse_beyond(inputs, layer, input, std::numeric_limits<double>::max(), "an input of");
    }
  }
  const bool ground_told = has_value(r.heights[0]);
  std::vector<HeightMap> told = wanted_of(wanted, goals, r.grid, r.heights.size(), scale);
  if (f.errors.empty()) r.targets = std::move(told);
  if (o.increments)
    sum_increments(r);
  else if (!maps.contains(0))
    std::ranges::fill(r.heights[0].cells, 0.0);
  if (!f.errors.empty()) set_targets_of_errors(r, told);
  if (!(o.increments ? ground_told : maps.contains(0)) && r.base == 0)
    r.assumptions.push_back("there is no file of layer 0: the ground is taken as flat at 0 mm");
  count_cells(r, ground_told);
  return r;
}

}  // namespace firn
