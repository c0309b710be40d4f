#include "lcmtypes/convert.h"

#include <cmath>

#include "core/grid/cell_quality.h"
#include "firn/enums.h"

namespace firn {

grid_t to_message(const GridSpec& s) {
  grid_t g{};
  g.nx = s.nx;
  g.ny = s.ny;
  g.pitch_x_mm = s.pitch_x_mm;
  g.pitch_y_mm = s.pitch_y_mm;
  g.origin_x_mm = s.origin_x_mm;
  g.origin_y_mm = s.origin_y_mm;
  return g;
}

GridSpec from_message(const grid_t& g) {
  return {g.nx, g.ny, g.pitch_x_mm, g.pitch_y_mm, g.origin_x_mm, g.origin_y_mm};
}

figure_t to_message(const Figure& f) {
  figure_t m{};
  m.known = 0;
  const auto number = [&m](const std::optional<double>& x, FigurePart part) {
    if (!x || !std::isfinite(*x)) return 0.0;
    m.known = std::int8_t(m.known | part);
    return *x;
  };
  m.value = number(f.value, kFigureValue);
  m.limit = number(f.limit, kFigureLimit);
  m.unit = f.unit;
  m.key = f.key;
  return m;
}

Figure from_message(const figure_t& m) {
  Figure f;
  if (m.known & kFigureValue) f.value = m.value;
  if (m.known & kFigureLimit) f.limit = m.limit;
  f.unit = m.unit;
  f.key = m.key;
  return f;
}

HeightMap height_of(const height_map_t& m) {
  HeightMap h(from_message(m.grid));
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = double(m.height_mm[c]);
  return h;
}

HeightMap measured_height_of(const height_map_t& m) {
  HeightMap h = height_of(m);
  if (m.rows_expected == 0) return h;
  for (std::size_t c = 0; c < h.size() && c < m.quality.size(); ++c)
    if (CellQuality(m.quality[c]) == CellQuality::kGuessed) h.cells[c] = kNotMeasured;
  return h;
}

void set_height(height_map_t& m, const HeightMap& h) {
  m.grid = to_message(h.spec);
  m.n = std::int32_t(h.size());
  m.height_mm.resize(h.size());
  for (std::size_t c = 0; c < h.size(); ++c) m.height_mm[c] = float(h.cells[c]);
}

DropletPattern drops_of(const layer_plan_t& p) {
  DropletPattern d(from_message(p.grid));
  for (std::size_t c = 0; c < d.size(); ++c) d.cells[c] = std::uint8_t(p.drops[c]);
  return d;
}

DropletPattern drops_of(const deposition_report_t& r) {
  DropletPattern d(from_message(r.grid));
  for (std::size_t c = 0; c < d.size(); ++c) d.cells[c] = std::uint8_t(r.drops[c]);
  return d;
}

void set_drops(layer_plan_t& p, const DropletPattern& d) {
  p.grid = to_message(d.spec);
  p.n = std::int32_t(d.size());
  p.passes = d.passes();
  p.drops.resize(d.size());
  for (std::size_t c = 0; c < d.size(); ++c) p.drops[c] = std::int8_t(d.cells[c]);
}

MaterialMap materials_of(const layer_plan_t& p) {
  if (p.n_material == 0) return {};
  MaterialMap materials(from_message(p.grid));
  for (std::size_t c = 0; c < materials.size(); ++c) materials.set(c, Material(p.material[c]));
  return materials;
}

void set_materials(layer_plan_t& p, const MaterialMap& materials) {
  p.n_material = std::int32_t(materials.size());
  p.material.assign(materials.cells.begin(), materials.cells.end());
}

OffsetMap offsets_of(const layer_plan_t& p) {
  if (p.n_offset == 0) return {};
  OffsetMap offsets(from_message(p.grid));
  offsets.cells.assign(p.offset.begin(), p.offset.end());
  return offsets;
}

void set_offsets(layer_plan_t& p, const OffsetMap& offsets) {
  p.n_offset = std::int32_t(offsets.size());
  p.offset.assign(offsets.cells.begin(), offsets.cells.end());
}

Placement placement_of(const stage_command_t& pass, const OffsetTable& table) {
  Placement placement{table, {}, pass.apart_mm};
  const GridSpec grid = from_message(pass.grid);
  if (pass.n_offset > 0) {
    placement.map = OffsetMap(grid);
    placement.map.cells.assign(pass.offset.begin(), pass.offset.end());
  }
  return placement;
}

void set_placement(stage_command_t& pass, const Placement& placement) {
  pass.apart_mm = placement.apart_mm;
  pass.n_offset = std::int32_t(placement.map.size());
  pass.offset.assign(placement.map.cells.begin(), placement.map.cells.end());
}

DropletPattern fires_of(const stage_command_t& pass) {
  DropletPattern d(from_message(pass.grid));
  for (std::size_t c = 0; c < d.size(); ++c) d.cells[c] = std::uint8_t(pass.fires[c]);
  return d;
}

trajectory_t to_message(const PlannedPath& p) {
  const Trajectory& t = p.trajectory;
  trajectory_t m{};
  m.path = t.id;
  m.layer = p.layer;
  m.material = std::int8_t(p.material);
  m.kind = std::int8_t(p.kind);
  m.tick_s = t.tick_s;
  m.axes = t.axes;
  m.axis_unit = t.axis_units;
  m.samples = std::int32_t(t.samples());
  m.n = std::int32_t(t.positions.size());
  m.position = t.positions;
  m.duration_s = t.certificate.duration_s;
  m.lower_bound_s = t.certificate.lower_bound_s;
  m.curvature_ramp_mm = t.certificate.curvature_ramp_mm;
  m.limits = std::int32_t(t.certificate.limits.size());
  for (const LimitRatio& l : t.certificate.limits) {
    m.limit.push_back(l.limit);
    m.ratio.push_back(l.ratio);
    m.time_s.push_back(l.time_s);
  }
  return m;
}

PlannedPath from_message(const trajectory_t& m) {
  PlannedPath p;
  p.layer = m.layer;
  p.material = std::uint8_t(m.material);
  p.kind = PathKind(m.kind);
  Trajectory& t = p.trajectory;
  t.id = m.path;
  t.tick_s = m.tick_s;
  t.axes = m.axes;
  t.axis_units = m.axis_unit;
  t.positions = m.position;
  t.certificate.duration_s = m.duration_s;
  t.certificate.lower_bound_s = m.lower_bound_s;
  t.certificate.curvature_ramp_mm = m.curvature_ramp_mm;
  for (std::size_t n = 0; n < m.limit.size(); ++n)
    t.certificate.limits.push_back({m.limit[n], m.ratio[n], m.time_s[n]});
  return p;
}

}  // namespace firn
