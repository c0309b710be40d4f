#include "files/layer_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "core/grid/npy.h"
#include "core/statistics/median.h"
#include "files/lowercase.h"
#include "files/nearest.h"
#include "files/separated_values.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostLayers = 100'000;
constexpr std::size_t kMostCells = std::size_t(1) << 28;  // of all layers: 2 GB
constexpr double kFarthest_mm = 1e6;  // of a position or height: beyond it stands no sample

struct Unit {
  std::string_view name;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1},        {"um", 1e-3},      {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3},
                           {"micron", 1e-3}, {"microns", 1e-3}, {"nm", 1e-6},        {"cm", 10},
                           {"m", 1000},      {"in", 25.4},      {"inch", 25.4},      {"mil", 0.0254},
                           {"thou", 0.0254}};

// "Height [um]", "height (um)", "height_um", "height um": the word and the unit.
struct Heading {
  std::string word, unit;
  bool bracketed = false;
};
Heading heading_of(const std::string& name) {
  Heading h;
  h.word = lowercase(name);
  if (const std::size_t open = h.word.find_first_of("[("); open != h.word.npos) {
    h.unit = h.word.substr(open + 1, h.word.find_first_of("])", open) - open - 1);
    h.word.resize(open);
    h.bracketed = true;
  } else if (const std::size_t at = h.word.find_last_of("_ "); at != h.word.npos) {
    const std::string last = h.word.substr(at + 1);
    if (std::ranges::find(kUnits, last, &Unit::name) != std::end(kUnits)) {
      h.unit = last;
      h.word.resize(at);
    }
  }
  while (!h.word.empty() && (h.word.back() == ' ' || h.word.back() == '_')) h.word.pop_back();
  return h;
}

struct Role {
  std::string_view role;
  std::vector<std::string_view> names;
};
const std::vector<Role>& roles() {
  static const std::vector<Role> all{
      {"layer", {"layer", "layer_number", "layer number", "layer_index", "k", "n"}},
      {"x", {"x", "pos", "position", "x_position"}},
      {"y", {"y", "y_position"}},
      {"segment", {"segment", "segment_index", "cell", "index", "i"}},
      {"height", {"height", "z", "h", "surface", "height_map"}},
      {"increment", {"increment", "dh", "dz", "layer_height", "height_increment", "bead_height"}},
      {"input",
       {"input", "u", "command", "commanded", "drops", "droplets", "commanded_input", "flow", "speed"}},
  };
  return all;
}

struct TableColumns {
  std::map<std::string, std::size_t, std::less<>> at;  // role -> field
  std::map<std::string, double, std::less<>> scale;    // of lengths, to mm
};

TableColumns columns_of(const SeparatedRow& head, const std::string& name, const LayerRecordOptions& o,
                        std::vector<std::string>& assumptions) {
  TableColumns c;
  const std::string place = name + ": line " + std::to_string(head.line);
  for (const auto& [role, wanted] : o.columns) {
    if (std::ranges::find(roles(), role, &Role::role) == roles().end())
      throw UsageError("--column " + role + "=" + wanted +
                       ": no such role; there are layer, x, y, segment, height, " + "increment, input");
    const auto it = std::ranges::find(head.fields, wanted);
    if (it == head.fields.end()) {
      const std::string near = nearest(wanted, {head.fields.begin(), head.fields.end()});
      throw UsageError(place + ": no column '" + wanted + "'" +
                       (near.empty() ? "" : "; the nearest is '" + near + "'"));
    }
    c.at[role] = std::size_t(it - head.fields.begin());
  }
  for (const Role& role : roles())
    for (std::size_t f = 0; f < head.fields.size() && !c.at.contains(role.role); ++f)
      if (std::ranges::find(role.names, heading_of(head.fields[f]).word) != role.names.end())
        c.at.emplace(role.role, f);
  if (!c.at.contains("layer"))
    throw UsageError(place + ": no column of the layer; --column layer=NAME names it");
  if (!c.at.contains("height") && !c.at.contains("increment"))
    throw UsageError(place + ": no column of height or increment; --column height=NAME names it");
  if (!c.at.contains("x") && !c.at.contains("segment"))
    throw UsageError(place + ": no column of x or segment; --column x=NAME names it");
  for (const char* role : {"x", "y", "height", "increment"}) {
    if (!c.at.contains(role)) continue;
    const Heading h = heading_of(head.fields[c.at[role]]);
    const std::string unit = !h.unit.empty() ? h.unit : o.unit;
    if (unit.empty())
      assumptions.push_back("column '" + head.fields[c.at[role]] + "' names no unit: taken as mm (--unit)");
    c.scale[role] =
        unit.empty() ? 1.0 : millimetres(unit, place + ": column '" + head.fields[c.at[role]] + "'");
  }
  return c;
}

struct Axis {
  int n = 1;
  double pitch = 1.0, origin = 0.0;
  int cell(double v) const { return int(std::lround((v - origin) / pitch)); }
};

// The pitch is the median distance of neighbours: a few odd positions do not move it.
Axis axis_of(std::vector<double> values, double pitch, const std::string& name, const char* axis) {
  Axis a;
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.empty()) return a;
  a.origin = values.front();
  const double span = values.back() - values.front();
  std::vector<double> steps;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (values[k] - values[k - 1] > 1e-6 * span) steps.push_back(values[k] - values[k - 1]);
  a.pitch = pitch > 0 ? pitch : steps.empty() ? 1.0 : statistics::upper_median(steps);
  const double cells = std::round(span / a.pitch) + 1;
  if (!(cells <= kMaxGridSide))
    throw UsageError(name + ": " + fmt::format("{:.9g}", cells) + " cells along " + axis +
                     " with a pitch of " + std::to_string(a.pitch) + " mm, more than " +
                     std::to_string(kMaxGridSide) + "; --pitch-mm sets it");
  a.n = int(cells);
  return a;
}

// Sums increments to heights; a cell that was not seen in a layer stays unknown from there on.
void sum_increments(LayerRecord& r) {
  for (std::size_t k = 1; k < r.heights.size(); ++k)
    for (std::size_t c = 0; c < r.heights[k].size(); ++c) r.heights[k].cells[c] += r.heights[k - 1].cells[c];
}

void refuse_size(const std::string& name, std::size_t layers, const GridSpec& grid) {
  if (layers * grid.size() > kMostCells)
    throw UsageError(name + ": " + std::to_string(layers) + " layers of " + std::to_string(grid.nx) + " x " +
                     std::to_string(grid.ny) + " cells are more than can be held");
}

// Of layers with a height; an assumed ground is none.
void count(LayerRecord& r, bool ground_known) {
  for (std::size_t k = ground_known ? 0 : 1; k < r.heights.size(); ++k) {
    const auto seen = std::ranges::count_if(r.heights[k].cells, [](double h) { return !std::isnan(h); });
    r.points += seen;
    if (seen > 0) r.missing += std::int64_t(r.heights[k].size()) - seen;
  }
}

struct Point {
  int layer = 0;
  double x = 0, y = 0, height = kNaN, input = kNaN;
  std::size_t line = 0;
};

std::string too_far(const std::string& what, double mm) {
  return fmt::format("{} = {:g} mm, not within {:g} mm of the origin", what, mm, kFarthest_mm);
}

std::vector<Point> points_of(const SeparatedValues& table, const TableColumns& c, const std::string& name,
                             bool increments, double segment_mm) {
  std::vector<Point> points;
  const auto scaled = [&](const SeparatedRow& row, const char* role) {
    return table.number(row, c.at.at(role)) * c.scale.at(role);
  };
  for (std::size_t n = 1; n < table.rows().size(); ++n) {
    const SeparatedRow& row = table.rows()[n];
    const auto wrong = [&](const std::string& what) {
      return UsageError(name + ": line " + std::to_string(row.line) + ": " + what);
    };
    const double layer = table.number(row, c.at.at("layer"));
    if (std::isnan(layer)) throw wrong("no layer");
    if (layer != std::floor(layer) || layer < 0 || layer > kMostLayers)
      throw wrong("layer " + std::to_string(layer) + " is not a number from 0 to " +
                  std::to_string(kMostLayers));
    Point p;
    p.line = row.line;
    p.layer = int(layer);
    p.x = c.at.contains("x") ? scaled(row, "x") : table.number(row, c.at.at("segment")) * segment_mm;
    p.y = c.at.contains("y") ? scaled(row, "y") : 0.0;
    if (std::isnan(p.x) || std::isnan(p.y)) throw wrong("no position");
    p.height = scaled(row, increments ? "increment" : "height");
    for (const auto& [what, mm] :
         std::initializer_list<std::pair<const char*, double>>{{"x", p.x}, {"y", p.y}, {"height", p.height}})
      if (std::abs(mm) > kFarthest_mm) throw wrong(too_far(what, mm));
    if (c.at.contains("input")) p.input = table.number(row, c.at.at("input"));
    if (std::isinf(p.input)) throw wrong("the input is infinite");
    points.push_back(p);
  }
  return points;
}

}  // namespace

double millimetres(std::string_view unit, const std::string& place) {
  for (const Unit& u : kUnits)
    if (u.name == unit) return u.mm;
  throw UsageError(place + ": unit '" + std::string(unit) +
                   "' is not known; there are mm, um, nm, cm, m, in, mil");
}

LayerRecord read_layer_table(std::string_view text, const std::string& name, const LayerRecordOptions& o) {
  const SeparatedValues table(text, name);
  if (table.rows().size() < 2) throw UsageError(name + ": no row below a line of column names");
  LayerRecord r;
  const TableColumns c = columns_of(table.rows().front(), name, o, r.assumptions);
  const bool increments = !c.at.contains("height");
  const std::vector<Point> points =
      points_of(table, c, name, increments, o.pitch_x_mm > 0 ? o.pitch_x_mm : 1.0);
  std::vector<double> xs, ys;
  int last = 0, first = kMostLayers;
  for (const Point& p : points) {
    xs.push_back(p.x);
    ys.push_back(p.y);
    last = std::max(last, p.layer);
    first = std::min(first, p.layer);
  }
  if (!c.at.contains("x") && o.pitch_x_mm <= 0)
    r.assumptions.push_back("segments have no length: taken as 1 mm (--pitch-mm)");
  const Axis x = axis_of(xs, o.pitch_x_mm, name, "x"), y = axis_of(ys, o.pitch_y_mm, name, "y");
  r.grid = {x.n, y.n, x.pitch, y.pitch, x.origin, y.origin};
  refuse_size(name, std::size_t(last) + 1, r.grid);
  r.heights.assign(std::size_t(last) + 1, HeightMap(r.grid, kNaN));
  if (c.at.contains("input")) r.inputs.assign(std::size_t(last), Grid<double>(r.grid, kNaN));
  std::vector<Grid<std::uint32_t>> seen(std::size_t(last) + 1, Grid<std::uint32_t>(r.grid, 0));
  for (const Point& p : points) {
    const std::size_t cell = r.grid.index(x.cell(p.x), y.cell(p.y));
    if (!std::isnan(p.height)) {  // several readings of one cell: their mean
      double& height = r.heights[std::size_t(p.layer)].cells[cell];
      const double n = ++seen[std::size_t(p.layer)].cells[cell];
      height = n > 1 ? height + (p.height - height) / n : p.height;
    }
    if (std::isnan(p.input) || p.layer == 0) continue;
    double& input = r.inputs[std::size_t(p.layer - 1)].cells[cell];
    if (!std::isnan(input) && input != p.input)
      throw UsageError(name + ": line " + std::to_string(p.line) + ": a second input of layer " +
                       std::to_string(p.layer) + " in the same cell, which differs; --pitch-mm parts cells");
    input = p.input;
  }
  if (first > 0) {
    std::ranges::fill(r.heights[0].cells, 0.0);
    r.assumptions.push_back("the record begins at layer " + std::to_string(first) +
                            ": the ground is taken as flat at 0 mm");
  }
  if (increments) sum_increments(r);
  count(r, first == 0);
  return r;
}

namespace {

// The last number in a file's name.
std::optional<int> number_in(const std::string& stem) {
  const std::size_t end = stem.find_last_of("0123456789");
  if (end == stem.npos) return {};
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1]))) --begin;
  if (end - begin > 8) return {};
  return std::stoi(stem.substr(begin, end - begin + 1));
}

std::map<int, fs::path> numbered_files(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw UsageError(folder.string() + ": no such folder");
  std::map<int, fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".npy" && ending != ".csv" && ending != ".txt") continue;
    const auto number = number_in(entry.path().stem().string());
    if (!number || *number > kMostLayers)
      throw UsageError(entry.path().string() + ": no number of a layer in its name");
    if (!files.emplace(*number, entry.path()).second)
      throw UsageError(entry.path().string() + ": a second file of layer " + std::to_string(*number));
  }
  if (files.empty()) throw UsageError(folder.string() + ": no .npy or .csv file");
  return files;
}

struct Matrix {
  std::vector<std::vector<double>> rows;
};

Matrix matrix_of(const fs::path& file) {
  Matrix m;
  const std::string text = read_file(file);
  if (file.extension() != ".npy") {
    const SeparatedValues table(text, file.string());
    if (table.has_header())
      throw UsageError(file.string() + ": line " + std::to_string(table.rows().front().line) +
                       ": a matrix of numbers has no column names");
    for (const SeparatedRow& row : table.rows()) {
      std::vector<double>& out = m.rows.emplace_back();
      for (std::size_t f = 0; f < row.fields.size(); ++f) out.push_back(table.number(row, f));
    }
    return m;
  }
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
  Grid<double> g(grid, kNaN);
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

}  // namespace

LayerRecord read_layer_files(const fs::path& heights, const fs::path& inputs, const LayerRecordOptions& o) {
  LayerRecord r;
  std::map<int, Matrix> maps, commands;
  for (const auto& [layer, file] : numbered_files(heights)) maps.emplace(layer, matrix_of(file));
  if (!inputs.empty())
    for (const auto& [layer, file] : numbered_files(inputs)) commands.emplace(layer, matrix_of(file));
  std::size_t nx = 0, ny = 0;
  for (const auto* some : {&maps, &commands})
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
  refuse_size(heights.string(), std::size_t(last) + 1, r.grid);
  r.heights.assign(std::size_t(last) + 1, HeightMap(r.grid, kNaN));
  for (const auto& [layer, m] : maps) {
    HeightMap& map = r.heights[std::size_t(layer)];
    map.cells = fitted(m, r.grid, scale).cells;
    refuse_beyond(heights, layer, map, kFarthest_mm, "a height [mm] of");
  }
  if (!commands.empty()) {
    r.inputs.assign(std::size_t(last), Grid<double>(r.grid, kNaN));
    for (const auto& [layer, m] : commands) {
      if (layer == 0) continue;
      Grid<double>& input = r.inputs[std::size_t(layer - 1)];
      input = fitted(m, r.grid, 1.0);
      refuse_beyond(inputs, layer, input, std::numeric_limits<double>::max(), "an input of");
    }
  }
  if (!maps.contains(0)) {
    std::ranges::fill(r.heights[0].cells, 0.0);
    r.assumptions.push_back("there is no file of layer 0: the ground is taken as flat at 0 mm");
  }
  count(r, maps.contains(0));
  return r;
}

}  // namespace firn
