// Settings of firn slice: the table is the documentation, reads back, and refuses unknown keys and values.
#include "config/slice.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "config/error.h"

using namespace firn;
using Catch::Contains;

namespace {

SliceSettings settings(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_slice_settings(text, "s.toml", overrides);
}

}  // namespace

TEST_CASE("The dump of settings reads back to the same settings") {
  const SliceSettings s = settings(
      "[mesh]\nscale = [2, 2, 0.5]\nplace_x = \"cent\"\nmaterial = [0, 2]\n[support]\nkind = "
      "\"overhang\"\n[gcode]\nstart = \"G28|M104 S200\"\n");
  CHECK(dump(settings(dump(s))) == dump(s));
  CHECK(dump(SliceSettings{}) == dump(settings("")));
}

TEST_CASE("Settings become what the slicer takes: Table 3-1, degrees, words, one value per mesh") {
  const SliceSettings s = settings(
      "[mesh]\nunit = \"inch\"\nrotation_deg = [-85, 0, 10]\nrotation_order = [3, 1, 2]\nplace_y = "
      "\"orig\"\nplace_x = \"number\"\nx_mm = [5, -40]\n"
      "material = [0, 2]\n[scaffold]\nfill = \"zigzag\"\nangle_deg = 90\n[support]\nkind = "
      "\"overhang\"\noverhang_deg = 60\n[order]\nseam = \"random\"\n[measure]\non = 1\n");
  const slice::Placement first = placement(s, 0), third = placement(s, 2);
  CHECK(first.unit_mm == 25.4);
  CHECK(placement(s, 0, 0.001).unit_mm == 0.001);  // a file that names its unit
  CHECK(first.rotation_deg == std::array<double, 3>{-85, 0, 10});
  CHECK(first.order == std::array<int, 3>{2, 0, 1});
  CHECK(first.translation[0].mode == slice::AxisPlace::Mode::kNumber);
  CHECK(first.translation[0].value_mm == 5.0);
  CHECK(third.translation[0].value_mm == -40.0);
  CHECK(first.translation[1].mode == slice::AxisPlace::Mode::kOriginal);
  CHECK(material_of(s, 0) == 0);
  CHECK(material_of(s, 5) == 2);
  const slice::PathOptions p = path_options(s);
  CHECK(p.scaffold.pattern == slice::FillPattern::kZigzag);
  CHECK(p.scaffold.fill_angle_rad == Approx(1.5707963268));
  CHECK(p.scaffold.first_offset_mm == 1.2);
  CHECK(p.part.first_offset_mm == 0.6);
  CHECK(p.support.kind == slice::Support::kOverhang);
  CHECK(p.support.overhang_rad == Approx(1.0471975512));
  CHECK(p.seam == slice::SeamPlacement::kRandom);
  CHECK(p.measure.on);
}

TEST_CASE("Overrides come after the file, and words need no quotation marks") {
  const SliceSettings s = settings("[layer]\nheight_mm = 0.5\n", {"layer.height_mm=0.1", "support.kind=none",
                                                                  "part.boundaries=2", "mesh.material=[2]"});
  CHECK(s.contour.layer_height_mm == 0.1);
  CHECK(s.support == "none");
  CHECK(s.part.bead.boundaries == 2);
  CHECK(material_of(s, 0) == 2);
}

TEST_CASE("Settings that make no sense are refused with key, value and limit") {
  CHECK_THROWS_WITH(
      settings("[layer]\nhight_mm = 1\n"),
      Contains("s.toml:2: layer.hight_mm: unknown key; the nearest known one is layer.height_mm"));
  CHECK_THROWS_WITH(settings("[layer]\nheight_mm = 0\n"), Contains("must lie in [0.001, 100] mm"));
  CHECK_THROWS_WITH(settings("[support]\nkind = \"ful\"\n"), Contains("one of full, overhang, none"));
  CHECK_THROWS_WITH(settings("[mesh]\nrotation_order = [1, 1, 2]\n"),
                    Contains("s.toml:2: mesh.rotation_order"));
  CHECK_THROWS_WITH(settings("[mesh]\nscale = [1, 0, 1]\n"), Contains("must not be 0"));
  CHECK_THROWS_WITH(settings("[mesh]\nmaterial = [1]\n"), Contains("which is the scaffold's"));
  CHECK_THROWS_WITH(settings("[mesh]\nx_mm = []\n"), Contains("must have an entry"));
  CHECK_THROWS_WITH(settings("", {"layer.height_mm"}), Contains("must read KEY=VALUE"));
  CHECK_THROWS_WITH(settings("", {"part.fil=lines"}),
                    Catch::Equals("--set: part.fil: unknown key; the nearest known one is part.fill"));
  CHECK_THROWS_WITH(settings("", {"part.fill=line"}),
                    Catch::StartsWith("--set: part.fill = 'line': ") && Contains("did you mean \"lines\"?"));
  CHECK_THROWS_WITH(settings("", {"layer.height_mm=thin"}),
                    Contains("--set: layer.height_mm = 'thin': must be a number"));
  CHECK_THROWS_WITH(settings("", {"part.fill=lines\nhook.on = 1"}), Contains("control characters"));
  CHECK_THROWS_WITH(settings("", {"layers.height_mm=1"}), Contains("the nearest known one is layer"));
  CHECK_THROWS_AS(load_slice_settings("no/such.toml"), ConfigError);
}

TEST_CASE("Every unit of length scales by its millimetres") {
  const std::pair<const char*, double> units[] = {{"um", 0.001}, {"mm", 1.0},    {"cm", 10.0},
                                                  {"m", 1000.0}, {"inch", 25.4}, {"foot", 304.8}};
  for (const auto& [name, unit_mm] : units)
    CHECK(placement(settings("[mesh]\nunit = \"" + std::string(name) + "\"\n"), 0).unit_mm == unit_mm);
}

TEST_CASE("Every word of placing, filling, support and seam becomes what it names") {
  using Mode = slice::AxisPlace::Mode;
  const std::pair<const char*, Mode> places[] = {
      {"number", Mode::kNumber}, {"cent", Mode::kCentre}, {"orig", Mode::kOriginal}, {"as_is", Mode::kAsIs}};
  for (const auto& [word, mode] : places)
    CHECK(placement(settings("[mesh]\nplace_z = \"" + std::string(word) + "\"\n"), 0).translation[2].mode ==
          mode);
  using slice::FillPattern;
  const std::pair<const char*, FillPattern> fills[] = {{"lines", FillPattern::kLines},
                                                       {"zigzag", FillPattern::kZigzag},
                                                       {"none", FillPattern::kNone},
                                                       {"concentric", FillPattern::kConcentric}};
  for (const auto& [word, pattern] : fills)
    CHECK(path_options(settings("[part]\nfill = \"" + std::string(word) + "\"\n")).part.pattern == pattern);
  using slice::Support;
  const std::pair<const char*, Support> supports[] = {
      {"none", Support::kNone}, {"overhang", Support::kOverhang}, {"full", Support::kFull}};
  for (const auto& [word, kind] : supports)
    CHECK(path_options(settings("[support]\nkind = \"" + std::string(word) + "\"\n")).support.kind == kind);
  using slice::SeamPlacement;
  const std::pair<const char*, SeamPlacement> seams[] = {{"aligned", SeamPlacement::kAligned},
                                                         {"random", SeamPlacement::kRandom},
                                                         {"nearest", SeamPlacement::kNearest}};
  for (const auto& [word, seam] : seams)
    CHECK(path_options(settings("[order]\nseam = \"" + std::string(word) + "\"\n")).seam == seam);
}

TEST_CASE("The slicer's tolerance is its share of the contour's, since rings add theirs") {
  const SliceSettings s = settings("", {"contour.tolerance_mm=0.08"});
  CHECK(path_options(s).chord_tolerance_mm == Approx(slice::kRingShare * 0.08));
}

TEST_CASE("docs/slice-settings.md is what `firn config docs --slice` writes") {
  std::ifstream in(FIRN_SOURCE_DIR "/docs/slice-settings.md");
  std::ostringstream committed;
  committed << in.rdbuf();
  const bool same = committed.str() == slice_markdown();
  CHECK(same);
}
