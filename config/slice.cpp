#include "config/slice.h"

#include <algorithm>
#include <numbers>

#include "config/error.h"
#include "config/field_rules.h"
#include "config/field_texts.h"
#include "config/include.h"
#include "config/reader.h"

namespace firn {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

double unit_mm(const std::string& unit) {
  return unit == "um"     ? 0.001
         : unit == "cm"   ? 10.0
         : unit == "m"    ? 1000.0
         : unit == "inch" ? 25.4
         : unit == "foot" ? 304.8
                          : 1.0;
}

template <class T>
const T& per_mesh(const std::vector<T>& list, std::size_t mesh) {
  return list[std::min(mesh, list.size() - 1)];
}

void check(SliceSettings& s, const Origins& origins, const std::string& file) {
  const FieldRules rules(slice_fields(s), origins, file);
  const auto& order = s.rotation_order;
  const auto has = [&](double axis) { return std::count(order.begin(), order.end(), axis) == 1; };
  rules.require(order.size() == 3 && has(1) && has(2) && has(3), "mesh.rotation_order",
                "must be 1, 2, 3 in some order");
  rules.require(s.rotation_deg.size() == 3, "mesh.rotation_deg", "must have three entries");
  rules.require(s.scale.size() == 3, "mesh.scale", "must have three entries");
  rules.require(std::count(s.scale.begin(), s.scale.end(), 0.0) == 0, "mesh.scale", "must not be 0");
  rules.require(!s.place_mm[0].empty(), "mesh.x_mm", "must have an entry");
  rules.require(!s.place_mm[1].empty(), "mesh.y_mm", "must have an entry");
  rules.require(!s.place_mm[2].empty(), "mesh.z_mm", "must have an entry");
  rules.require(!s.materials.empty(), "mesh.material", "must have an entry");
  rules.require(std::all_of(s.materials.begin(), s.materials.end(),
                            [](double m) { return m == double(int(m)) && m != slice::kScaffoldMaterial; }),
                "mesh.material", "must be whole numbers but 1, which is the scaffold's");
}

}  // namespace

SliceSettings parse_slice_settings(const std::string& toml_text, const std::string& file_name,
                                   const std::vector<std::string>& overrides) {
  SliceSettings s;
  const Origins origins = read_fields(slice_fields(s), toml_text, file_name, overrides);
  check(s, origins, file_name);
  return s;
}

SliceSettings load_slice_settings(const std::filesystem::path& path,
                                  const std::vector<std::string>& overrides) {
  return path.empty() ? parse_slice_settings("", "", overrides)
                      : parse_slice_settings(read_config_text(path), path.string(), overrides);
}

std::string dump(SliceSettings settings) { return fields_toml(slice_fields(settings)); }

std::string slice_markdown() {
  SliceSettings defaults;
  return "# Settings of firn slice\n\n"
         "Written by `firn config docs --slice`. A settings file (`experiments/slicing/gear.toml`) is TOML;\n"
         "every key has the default shown here, which is the Cobra 600's rapid freeze prototyping [Barnett\n"
         "2012, ch. 3]. An unknown key is refused with the nearest known one.\n" +
         fields_markdown(slice_fields(defaults));
}

slice::Placement placement(const SliceSettings& s, std::size_t mesh, double file_unit_mm) {
  slice::Placement p;
  p.unit_mm = file_unit_mm > 0.0 ? file_unit_mm : unit_mm(s.unit);
  for (std::size_t a = 0; a < 3; ++a) {
    p.scale[a] = s.scale[a];
    p.rotation_deg[a] = s.rotation_deg[a];
    p.order[a] = int(s.rotation_order[a]) - 1;
    using Mode = slice::AxisPlace::Mode;
    const std::string& word = s.place[a];
    p.translation[a].mode = word == "number" ? Mode::kNumber
                            : word == "cent" ? Mode::kCentre
                            : word == "orig" ? Mode::kOriginal
                                             : Mode::kAsIs;
    p.translation[a].value_mm = per_mesh(s.place_mm[a], mesh);
  }
  return p;
}

std::uint8_t material_of(const SliceSettings& s, std::size_t mesh) {
  return std::uint8_t(per_mesh(s.materials, mesh));
}

slice::PathOptions path_options(const SliceSettings& s) {
  slice::PathOptions p = s.paths;
  const auto bead = [](const BeadSettings& b) {
    slice::ExtrusionOptions o = b.bead;
    using enum slice::FillPattern;
    o.pattern = b.fill == "lines"    ? kLines
                : b.fill == "zigzag" ? kZigzag
                : b.fill == "none"   ? kNone
                                     : kConcentric;
    o.fill_angle_rad = b.angle_deg * kRadians;
    o.fill_turn_rad = b.turn_deg * kRadians;
    return o;
  };
  p.part = bead(s.part);
  p.scaffold = bead(s.scaffold);
  p.support.kind = s.support == "none"       ? slice::Support::kNone
                   : s.support == "overhang" ? slice::Support::kOverhang
                                             : slice::Support::kFull;
  p.support.overhang_rad = s.overhang_deg * kRadians;
  p.hook.on = s.hook != 0;
  p.measure.on = s.measure != 0;
  p.measure.material = std::uint8_t(s.measured_material);
  p.measure.angle_rad = s.measure_angle_deg * kRadians;
  p.chord_tolerance_mm = slice::kRingShare * s.contour.chord_tolerance_mm;
  p.seam = s.seam == "aligned"  ? slice::SeamPlacement::kAligned
           : s.seam == "random" ? slice::SeamPlacement::kRandom
                                : slice::SeamPlacement::kNearest;
  return p;
}

}  // namespace firn
