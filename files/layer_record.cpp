#include "files/layer_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "core/statistics/median.h"
#include "files/column_heading.h"
#include "files/increments.h"
#include "files/layer_limits.h"
#include "files/nearest.h"
#include "files/separated_values.h"
#include "files/usage_error.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

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
      {"input", {"input", "u", "command", "commanded", "drops", "droplets", "commanded_input", "flow"}},
      {"speed", {"speed", "v", "velocity", "torch_speed", "travel_speed", "feed_rate", "feedrate"}},
      {"target", {"target", "target_height", "desired_height", "height_target"}},
      {"error", {"error", "height_error"}},
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
  const std::string place = name + ":" + std::to_string(head.line);
  for (const auto& [role, wanted] : o.columns) {
    if (std::ranges::find(roles(), role, &Role::role) == roles().end())
      throw UsageError("--column " + role + "=" + wanted +
                       ": no such role; there are layer, x, y, segment, height, increment, input, speed, "
                       "target, error");
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
  for (const char* role : {"x", "y", "height", "increment", "target", "error"}) {
    if (!c.at.contains(role)) continue;
    const ColumnHeading h = heading_of(head.fields[c.at[role]]);
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

struct Point {
  int layer = 0;
  double x = 0, y = 0, height = kUnmeasured, input = kUnmeasured, wanted = kUnmeasured;
  std::int64_t line = 0;
};

// Adds a reading to the mean of its cell.
void add_reading(double value, double& mean, std::uint32_t& n) {
  if (std::isnan(value)) return;
  mean = ++n > 1 ? mean + (value - mean) / n : value;
}

/// Scale of the input's numbers; speeds without a unit are taken as mm/s.
double input_scale(const SeparatedRow& head, const TableColumns& c, const std::string& name,
                   std::vector<std::string>& assumptions) {
  if (!c.at.contains("speed")) return 1.0;
  const std::string& column = head.fields[c.at.find("speed")->second];
  const ColumnHeading h = heading_of(column);
  if (h.unit.empty()) {
    assumptions.push_back("column '" + column + "' names no unit: taken as mm/s");
    return 1.0;
  }
  const auto scale = speed_unit_mm_s(h.unit);
  if (!scale)
    throw UsageError(name + ":" + std::to_string(head.line) + ": column '" + column + "': unit '" + h.unit +
                     "' is no speed, as mm/s or mm/min");
  return *scale;
}

std::string too_far(const std::string& what, double mm) {
  return fmt::format("{} = {:g} mm, not within {:g} mm of the origin", what, mm, kFarthest_mm);
}

/// The rows below the names of the columns.
std::vector<Point> points_of(SeparatedValues& table, const SeparatedRow& head, const TableColumns& c,
                             bool increments, double segment_mm, double input_scale) {
  std::vector<Point> points;
  SeparatedRow row;
  const auto number = [&](const char* role) {
    const std::size_t field = c.at.find(role)->second;
    return table.number(row, field, head.fields[field]);
  };
  const auto scaled = [&](const char* role) { return number(role) * c.scale.find(role)->second; };
  while (table.next(row)) {
    if (row.blank()) continue;
    const auto wrong = [&](const std::string& what) { table.fail(row.line, what); };
    const double layer = number("layer");
    if (std::isnan(layer)) wrong("no layer");
    if (layer != std::floor(layer) || layer < 0 || layer > kMaxLayers)
      wrong(fmt::format("layer {:g} is not a whole number from 0 to {}", layer, kMaxLayers));
    Point p;
    p.line = row.line;
    p.layer = int(layer);
    p.x = c.at.contains("x") ? scaled("x") : number("segment") * segment_mm;
    p.y = c.at.contains("y") ? scaled("y") : 0.0;
    if (std::isnan(p.x) || std::isnan(p.y)) wrong("no position");
    p.height = scaled(increments ? "increment" : "height");
    for (const char* role : {"error", "target"})  // a target goes before an error
      if (c.at.contains(role)) p.wanted = scaled(role);
    for (const auto& [what, mm] : std::initializer_list<std::pair<const char*, double>>{
             {"x", p.x}, {"y", p.y}, {"height", p.height}, {"target or error", p.wanted}})
      if (std::abs(mm) > kFarthest_mm) wrong(too_far(what, mm));
    for (const char* role : {"input", "speed"})
      if (c.at.contains(role)) p.input = number(role) * input_scale;
    points.push_back(p);
  }
  return points;
}

}  // namespace

void check_record_size(const std::string& name, std::size_t layers, const GridSpec& grid) {
  if (layers * grid.size() > kMaxCells)
    throw UsageError(name + ": " + std::to_string(layers) + " layers of " + std::to_string(grid.nx) + " x " +
                     std::to_string(grid.ny) + " cells are more than can be held");
}

void count_cells(LayerRecord& r, bool ground_known) {
  for (std::size_t k = std::size_t(ground_known ? 0 : r.base + 1); k < r.heights.size(); ++k) {
    const auto known = std::ranges::count_if(r.heights[k].cells, [](double h) { return !std::isnan(h); });
    r.points += known - (r.bridged.empty() ? 0 : r.bridged[k].count());
    if (known > 0) r.missing += std::int64_t(r.heights[k].size()) - known;
  }
}

void set_targets_of_errors(LayerRecord& r, const std::vector<HeightMap>& errors) {
  r.targets = r.heights;
  for (std::size_t k = 0; k < r.targets.size(); ++k)
    for (std::size_t c = 0; c < r.targets[k].size(); ++c) r.targets[k].cells[c] -= errors[k].cells[c];
}

void sum_increments(LayerRecord& r) {
  const std::optional<int> base = base_layer(r.heights);
  if (!base) return;
  HeightMap ground(r.grid, 0.0);
  bool wanted = false;
  if (!r.targets.empty() && *base > 0) {
    HeightMap target = r.targets[std::size_t(*base)];
    fill_along_x(target);
    wanted = !std::isnan(target.cells.front());
    if (wanted) ground = std::move(target);
  }
  IntegratedHeights sums = integrate_increments(std::move(r.heights), ground);
  r.heights = std::move(sums.heights);
  r.bridged = std::move(sums.bridged);
  r.bridges = sums.bridges;
  r.base = sums.base;
  if (r.base > 0)
    r.assumptions.push_back(
        fmt::format("no increment is told up to layer {}: heights count from its surface, taken as {}",
                    r.base, wanted ? "at its target" : "flat at 0 mm"));
  if (r.bridges > 0)
    r.assumptions.push_back(fmt::format(
        "{} missing increments are interpolated along x, so that the layers above them have heights; "
        "these cells are marked as not measured",
        r.bridges));
}

double millimetres(std::string_view unit, const std::string& place) {
  if (const auto mm = length_unit_mm(unit)) return *mm;
  throw UsageError(place + ": unit '" + std::string(unit) + "' is not known; there are " + kLengthUnits);
}

LayerRecord read_layer_table(std::string_view text, const std::string& name, const LayerRecordOptions& o) {
  std::istringstream in{std::string(text)};
  SeparatedValues table(in, name);
  SeparatedRow head;
  while (head.blank())
    if (!table.next(head)) throw UsageError(name + ": no row below a line of column names: it is empty");
  if (std::ranges::all_of(head.fields, [&](const std::string& f) { return table.is_value(f); }))
    table.fail(head.line, "numbers, where the names of the columns are needed");
  LayerRecord r;
  const TableColumns c = columns_of(head, name, o, r.assumptions);
  const bool increments = !c.at.contains("height");
  if (c.at.contains("input") && c.at.contains("speed"))
    throw UsageError(name + ":" + std::to_string(head.line) + ": columns '" + head.fields[c.at.at("input")] +
                     "' and '" + head.fields[c.at.at("speed")] +
                     "': input and speed are one input told twice");
  r.input_is_speed = c.at.contains("speed");
  const bool wanted = c.at.contains("target") || c.at.contains("error");
  const std::vector<Point> points =
      points_of(table, head, c, increments, o.pitch_x_mm > 0 ? o.pitch_x_mm : 1.0,
                input_scale(head, c, name, r.assumptions));
  if (points.empty()) throw UsageError(name + ": no row below the line of column names");
  std::vector<double> xs, ys;
  int last = 0, first = kMaxLayers;
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
  check_record_size(name, std::size_t(last) + 1, r.grid);
  r.heights.assign(std::size_t(last) + 1, HeightMap(r.grid, kUnmeasured));
  if (c.at.contains("input") || r.input_is_speed)
    r.inputs.assign(std::size_t(last), Grid<double>(r.grid, kUnmeasured));
  std::vector<HeightMap> told(wanted ? std::size_t(last) + 1 : 0, HeightMap(r.grid, kUnmeasured));
  std::vector<Grid<std::uint32_t>> seen(std::size_t(last) + 1, Grid<std::uint32_t>(r.grid, 0));
  std::vector<Grid<std::uint32_t>> told_seen(told.size(), Grid<std::uint32_t>(r.grid, 0));
  for (const Point& p : points) {
    const std::size_t cell = r.grid.index(x.cell(p.x), y.cell(p.y)), layer = std::size_t(p.layer);
    add_reading(p.height, r.heights[layer].cells[cell], seen[layer].cells[cell]);
    if (wanted) add_reading(p.wanted, told[layer].cells[cell], told_seen[layer].cells[cell]);
    if (std::isnan(p.input) || p.layer == 0) continue;
    double& input = r.inputs[std::size_t(p.layer - 1)].cells[cell];
    if (!std::isnan(input) && input != p.input)
      table.fail(p.line, "a second input of layer " + std::to_string(p.layer) +
                             " in the same cell, which differs; --pitch-mm parts cells");
    input = p.input;
  }
  const bool ground_told = has_value(r.heights[0]);
  if (c.at.contains("target")) r.targets = std::move(told);
  if (increments)
    sum_increments(r);
  else if (first > 0)
    std::ranges::fill(r.heights[0].cells, 0.0);
  if (!ground_told && r.base == 0)
    r.assumptions.push_back("the record begins at layer " + std::to_string(std::max(1, first)) +
                            ": the ground is taken as flat at 0 mm");
  if (c.at.contains("error") && r.targets.empty()) set_targets_of_errors(r, told);
  count_cells(r, ground_told);
  return r;
}

}  // namespace firn
