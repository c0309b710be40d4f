#include "config/field_rows.h"
#include "config/slice.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kPlace_mm = 1e5;

Table mesh(SliceSettings& s) {
  return {
      {"mesh.unit", &s.unit, "", one_of({"mm", "um", "cm", "m", "inch", "foot"}),
       "of the numbers in the files; 3MF names its own"},
      {"mesh.facet_count", &s.facet_count, "", one_of({"agree", "header", "file"}),
       "where an STL's or PLY's header counts other facets than the file holds: agree refuses the file"},
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
      {"mesh.x_mm", &s.place_mm[0], "mm", within(-kPlace_mm, kPlace_mm),
       "per mesh; the last holds for all further ones"},
      {"mesh.y_mm", &s.place_mm[1], "mm", within(-kPlace_mm, kPlace_mm), "the same along y"},
      {"mesh.z_mm", &s.place_mm[2], "mm", within(-kPlace_mm, kPlace_mm), "the same along z"},
      {"mesh.material", &s.materials, "", within(0, 250),
       "per mesh: 0 = part, 2, 3, ... = further ones; 1 is the scaffold's. Where meshes overlap the first "
       "has its way"},
  };
}

Table contour(SliceSettings& s) {
  slice::SliceOptions& c = s.contour;
  Table t{
      row("layer.height_mm", c.layer_height_mm, slice::kLayerHeight),
      row("contour.tolerance_mm", c.chord_tolerance_mm, slice::kChordTolerance),
  };
  add(t, rows("contour.", c, slice::kContourOptions));
  return t;
}

Table bead(BeadSettings& b, const std::string& section) {
  Table t = rows(section, b.bead, slice::kExtrusionRings);
  add(t, {
             {section + "fill", &b.fill, "", one_of({"concentric", "lines", "zigzag", "none"}),
              "lines: ZZFILL, not linked; zigzag: linked [3.5]"},
             row(section + "fill_width_mm", b.bead.fill_width_mm, slice::kExtrusionFillWidth),
             {section + "angle_deg", &b.angle_deg, "deg", within(-360, 360),
              "direction of lines and zigzags in odd layers"},
             {section + "turn_deg", &b.turn_deg, "deg", within(-360, 360), "added in even layers"},
             row(section + "gap_mm", b.bead.gap_mm, slice::kExtrusionGap),
             {section + "tool", &b.tool, "", {}, "of the machine of firn plan; empty = the flange"},
         });
  return t;
}

Table scaffold_and_more(SliceSettings& s) {
  slice::PathOptions& p = s.paths;
  Table t{
      {"support.kind", &s.support, "", one_of({"full", "overhang", "none"}),
       "full: below and around everything [3.3]"},
      row("support.buffer_mm", p.support.buffer_mm, slice::kSupportBuffer),
      {"support.overhang_deg", &s.overhang_deg, "deg", above(0, 89),
       "overhang: walls that lean out further, from the vertical, are supported"},
      {"hook.on", &s.hook, "", within(0, 1),
       "1 = ice hook wall: outermost scaffold paths are ice [3.7, Fig. 3-8]"},
  };
  add(t, rows("hook.", p.hook, slice::kHookOptions));
  add(t, {{"order.seam", &s.seam, "", one_of({"nearest", "aligned", "random"}), "where closed paths begin"}});
  add(t, rows("order.", p, slice::kPathOrder));
  add(t, {
             {"measure.on", &s.measure, "", within(0, 1), "1 = paths of the laser over each finished layer"},
             {"measure.material", &s.measured_material, "", within(0, 250), "over this material"},
             row("measure.spacing_mm", p.measure.spacing_mm, slice::kMeasureSpacing),
             {"measure.angle_deg", &s.measure_angle_deg, "deg", within(-360, 360), "direction of scan lines"},
         });
  add(t, rows("measure.", p.measure, slice::kMeasurePlace));
  add(t, {
             {"measure.tool", &s.laser_tool, "", {}, "of the machine of firn plan"},
             {"coverage.on", &s.coverage, "", within(0, 1),
              "1 = report gaps and overlaps per layer as area (slow)"},
             {"coverage.pitch_mm", &s.coverage_pitch_mm, "mm", within(0.01, 10), "between its scan lines"},
         });
  return t;
}

Table gcode(GcodeSettings& g) {
  return {
      {"gcode.boundary_mm_s", &g.boundary_mm_s, "mm/s", above(0, 1e4), "speed of boundary and hook paths"},
      {"gcode.fill_mm_s", &g.fill_mm_s, "mm/s", above(0, 1e4), "speed of fill paths"},
      {"gcode.travel_mm_s", &g.travel_mm_s, "mm/s", above(0, 1e4), "speed between paths"},
      {"gcode.filament_mm", &g.filament_mm, "mm", within(0, 100),
       "E counts mm of filament of this diameter; 0 = mm^3"},
      {"gcode.x_mm", &g.x_mm, "mm", within(-kPlace_mm, kPlace_mm), "added to x"},
      {"gcode.y_mm", &g.y_mm, "mm", within(-kPlace_mm, kPlace_mm), "added to y"},
      {"gcode.start", &g.start, "", {}, "further lines at the start, '|' between them"},
      {"gcode.end", &g.end, "", {}, "further lines at the end"},
  };
}

}  // namespace

std::vector<Field> slice_fields(SliceSettings& s) {
  Table t = mesh(s);
  add(t, contour(s));
  add(t, bead(s.part, "part."));
  add(t, bead(s.scaffold, "scaffold."));
  add(t, scaffold_and_more(s));
  add(t, gcode(s.gcode));
  return t;
}

}  // namespace firn
