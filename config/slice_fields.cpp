#include "config/field_rows.h"
#include "config/slice.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kMm = 1e5;

Table mesh(SliceSettings& s) {
  return {
      {"mesh.unit", &s.unit, "", one_of({"mm", "um", "cm", "m", "inch", "foot"}),
       "of the numbers in the files; 3MF names its own"},
      {"mesh.scale", &s.scale, "", within(-1e4, 1e4),
       "along x, y, z, none of them 0 [Barnett 2012, Table 3-1]"},
      {"mesh.rotation_deg", &s.rotation_deg, "deg", within(-3600, 3600),
       "about the x, y, z axes of a space-fixed frame [3.1.2]"},
      {"mesh.rotation_order", &s.rotation_order, "", within(1, 3),
       "which axis turns first, second, third: 1 = x, 2 = y, 3 = z"},
      {"mesh.place_x", &s.place[0], "", one_of({"as_is", "number", "cent", "orig"}),
       "number: the smallest x becomes x_mm; cent: centred on 0; orig: centred where it was in the file"},
      {"mesh.place_y", &s.place[1], "", one_of({"as_is", "number", "cent", "orig"}), "the same along y"},
      {"mesh.place_z", &s.place[2], "", one_of({"as_is", "number", "cent", "orig"}),
       "the same along z; number with z_mm = 0 stands on the platform"},
      {"mesh.x_mm", &s.place_mm[0], "mm", within(-kMm, kMm), "per mesh; the last holds for all further ones"},
      {"mesh.y_mm", &s.place_mm[1], "mm", within(-kMm, kMm), "the same along y"},
      {"mesh.z_mm", &s.place_mm[2], "mm", within(-kMm, kMm), "the same along z"},
      {"mesh.material", &s.materials, "", within(0, 250),
       "per mesh: 0 = part, 2, 3, ... = further ones; 1 is the scaffold's. Where meshes overlap the first "
       "has its way"},
  };
}

Table contour(SliceSettings& s) {
  slice::SliceOptions& c = s.contour;
  return {
      {"layer.height_mm", &c.layer_height_mm, "mm", above(0.001, 100),
       "layer n is cut once, at (n - 1/2) of this"},
      {"contour.tolerance_mm", &c.chord_tolerance_mm, "mm", within(0, 10),
       "no path leaves its exact place by more; 0 keeps every point"},
      {"contour.min_spacing_mm", &c.min_spacing_mm, "mm", within(0, 100),
       "PATHFILTER: points closer together go first (3.2: 0.4)"},
      {"contour.closing_gap_mm", &c.closing_gap_mm, "mm", within(0, 1000),
       "ends of open contours at most so far apart are joined"},
      {"contour.closing_share", &c.closing_share, "", within(0, 1),
       "then a contour whose own ends lie within this share of its length is closed"},
  };
}

Table bead(BeadSettings& b, const std::array<std::string_view, 9>& keys) {
  return {
      {keys[0], &b.bead.first_offset_mm, "mm", within(0, 100),
       "outline to the centre of the outermost path [3.7]"},
      {keys[1], &b.bead.boundary_width_mm, "mm", above(0, 100), "of boundary paths"},
      {keys[2], &b.bead.boundaries, "", within(1, 1000), "boundary paths side by side"},
      {keys[3], &b.fill, "", one_of({"concentric", "lines", "zigzag", "none"}),
       "lines: ZZFILL, not linked; zigzag: linked [3.5]"},
      {keys[4], &b.bead.fill_width_mm, "mm", above(0, 100), "of fill paths, which may spread [3.7]"},
      {keys[5], &b.angle_deg, "deg", within(-360, 360), "direction of lines and zigzags in odd layers"},
      {keys[6], &b.turn_deg, "deg", within(-360, 360), "added in even layers"},
      {keys[8], &b.bead.gap_mm, "mm", within(0, 100),
       "wider spots between rings, and thin parts, get beads of their own width; 0: none do"},
      {keys[7], &b.tool, "", {}, "of the machine of firn plan; empty = the flange"},
  };
}

Table scaffold_and_more(SliceSettings& s) {
  slice::PathOptions& p = s.paths;
  return {
      {"support.kind", &s.support, "", one_of({"full", "overhang", "none"}),
       "full: below and around everything [3.3]"},
      {"support.buffer_mm", &p.support.buffer_mm, "mm", within(0, 1000),
       "outward growth of what lies above [Table 3-1]"},
      {"support.overhang_deg", &s.overhang_deg, "deg", above(0, 89),
       "overhang: walls that lean out further, from the vertical, are supported"},
      {"hook.on", &s.hook, "", within(0, 1),
       "1 = ice hook wall: outermost scaffold paths are ice [3.7, Fig. 3-8]"},
      {"hook.two_from_layer", &p.hook.two_from_layer, "", within(0, 1e6),
       "one path up to this layer, two above"},
      {"hook.last_layer", &p.hook.last_layer, "", within(0, 1e6), "no hook above"},
      {"hook.clearance_mm", &p.hook.clearance_mm, "mm", within(0, 1000),
       "extra scaffold outward until hook and part are so far apart"},
      {"order.seam", &s.seam, "", one_of({"nearest", "aligned", "random"}), "where closed paths begin"},
      {"order.seed", &p.seed, "", within(0, 9e18), "of random seams"},
      {"order.two_opt_passes", &p.two_opt_passes, "", within(0, 100),
       "over the order of a layer's paths; 0 = nearest neighbour only"},
      {"order.start_x_mm", &p.start_x_mm, "mm", within(-kMm, kMm),
       "where the nozzle waits before each layer"},
      {"order.start_y_mm", &p.start_y_mm, "mm", within(-kMm, kMm), "the same along y"},
      {"measure.on", &s.measure, "", within(0, 1), "1 = paths of the laser over each finished layer"},
      {"measure.material", &s.measured_material, "", within(0, 250), "over this material"},
      {"measure.spacing_mm", &p.measure.spacing_mm, "mm", above(0, 1000), "between scan lines"},
      {"measure.angle_deg", &s.measure_angle_deg, "deg", within(-360, 360), "direction of scan lines"},
      {"measure.inset_mm", &p.measure.inset_mm, "mm", within(0, 1000), "stay so far inside the outline"},
      {"measure.laser_x_mm", &p.measure.laser_x_mm, "mm", within(-kMm, kMm),
       "laser spot seen from the nozzle; 0, 0 where firn plan knows the tool"},
      {"measure.laser_y_mm", &p.measure.laser_y_mm, "mm", within(-kMm, kMm), "the same along y"},
      {"measure.tool", &s.laser_tool, "", {}, "of the machine of firn plan"},
      {"coverage.on", &s.coverage, "", within(0, 1), "1 = report gaps and overlaps per layer as area (slow)"},
      {"coverage.pitch_mm", &s.coverage_pitch_mm, "mm", within(0.01, 10), "between its scan lines"},
  };
}

Table gcode(GcodeSettings& g) {
  return {
      {"gcode.boundary_mm_s", &g.boundary_mm_s, "mm/s", above(0, 1e4), "speed of boundary and hook paths"},
      {"gcode.fill_mm_s", &g.fill_mm_s, "mm/s", above(0, 1e4), "speed of fill paths"},
      {"gcode.travel_mm_s", &g.travel_mm_s, "mm/s", above(0, 1e4), "speed between paths"},
      {"gcode.filament_mm", &g.filament_mm, "mm", within(0, 100),
       "E counts mm of filament of this diameter; 0 = mm^3"},
      {"gcode.x_mm", &g.x_mm, "mm", within(-kMm, kMm), "added to x"},
      {"gcode.y_mm", &g.y_mm, "mm", within(-kMm, kMm), "added to y"},
      {"gcode.start", &g.start, "", {}, "further lines at the start, '|' between them"},
      {"gcode.end", &g.end, "", {}, "further lines at the end"},
  };
}

}  // namespace

std::vector<Field> slice_fields(SliceSettings& s) {
  Table t = mesh(s);
  add(t, contour(s));
  add(t, bead(s.part, {"part.first_offset_mm", "part.boundary_width_mm", "part.boundaries", "part.fill",
                       "part.fill_width_mm", "part.angle_deg", "part.turn_deg", "part.tool", "part.gap_mm"}));
  add(t, bead(s.scaffold, {"scaffold.first_offset_mm", "scaffold.boundary_width_mm", "scaffold.boundaries",
                           "scaffold.fill", "scaffold.fill_width_mm", "scaffold.angle_deg",
                           "scaffold.turn_deg", "scaffold.tool", "scaffold.gap_mm"}));
  add(t, scaffold_and_more(s));
  add(t, gcode(s.gcode));
  return t;
}

}  // namespace firn
