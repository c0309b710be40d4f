#include "lcmtypes/convert.h"

namespace firn {

grid_t to_message(const GridSpec& s) {
  grid_t g;
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

HeightMap height_of(const height_map_t& m) {
  HeightMap h(from_message(m.grid));
  for (std::size_t c = 0; c < h.size(); ++c) h.cells[c] = double(m.height_mm[c]);
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

void set_drops(layer_plan_t& p, const DropletPattern& d) {
  p.grid = to_message(d.spec);
  p.n = std::int32_t(d.size());
  p.passes = d.passes();
  p.drops.resize(d.size());
  for (std::size_t c = 0; c < d.size(); ++c) p.drops[c] = std::int8_t(d.cells[c]);
}

MaterialMap materials_of(const material_map_t& m) {
  MaterialMap materials(from_message(m.grid));
  for (std::size_t c = 0; c < materials.size(); ++c) materials.set(c, Material(m.material[c]));
  return materials;
}

void set_materials(material_map_t& m, const MaterialMap& materials) {
  m.grid = to_message(materials.spec);
  m.n = std::int32_t(materials.size());
  m.material.assign(materials.cells.begin(), materials.cells.end());
}

}  // namespace firn
