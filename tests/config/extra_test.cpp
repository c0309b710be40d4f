// Parameters that a scheme declares itself: [control.extra].
#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "config/experiment.h"
#include "config/field_texts.h"
#include "config/fields.h"
#include "config/ice_lab.h"
#include "config/reader.h"
#include "core/control/surface/adaptive_surface.h"

namespace firn {
namespace {

constexpr std::array<std::string_view, 2> kWords{"up", "down"};
constexpr std::array kToy{
    control::ExtraOption{"toy_mm", 0.5, "mm", within(0, 2), "a length"},
    control::ExtraOption{"toy_cells", std::int64_t(3), "cells", within(1, 9), "a count"},
    control::ExtraOption{"toy_way", std::string_view("up"), "", Range{}, "a word", kWords},
};

TEST_CASE("a scheme's declaration alone gives typed, limited and documented keys") {
  control::ExtraValues values;
  const auto table = extra_fields(kToy, "toy", values);
  CHECK(values.number("toy_mm") == 0.5);
  CHECK(values.integer("toy_cells") == 3);
  CHECK(values.text("toy_way") == "up");
  read_fields(table, "[control.extra]\ntoy_mm = 1.25\ntoy_cells = 7\ntoy_way = \"down\"\n", "x.toml", {});
  CHECK(values.number("toy_mm") == 1.25);
  CHECK(values.integer("toy_cells") == 7);
  CHECK(values.text("toy_way") == "down");
  const auto refused = [&](const std::string& line) {
    read_fields(table, "[control.extra]\n" + line + "\n", "x.toml", {});
  };
  CHECK_THROWS_WITH(refused("toy_mm = 3"),
                    Catch::Contains("x.toml:2: control.extra.toy_mm = 3") && Catch::Contains("[0, 2] mm"));
  CHECK_THROWS_WITH(refused("toy_cells = 1.5"), Catch::Contains("must be an integer"));
  CHECK_THROWS_WITH(refused("toy_way = \"left\""), Catch::Contains("one of up, down"));
  CHECK_THROWS_WITH(refused("toy_m = 1"), Catch::Contains("control.extra.toy_mm"));
  CHECK_THROWS_WITH(values.number("toy_cells"), Catch::Contains("control.extra.toy_cells"));
}

TEST_CASE("no two keys have one name") {
  Experiment e;
  std::set<std::string> seen;
  for (const Field& f : fields(e)) CHECK(seen.insert(f.key).second);
}

TEST_CASE("smf_adaptive reads its own parameters, and no other scheme has them") {
  const std::string adaptive =
      "[lab]\nkind = \"ice\"\n[ice]\nmesh = \"x.stl\"\nslice = \"s.toml\"\nmachine = "
      "\"m.toml\"\n[control]\nscheme = "
      "\"smf_adaptive\"\n[control.extra]\n";
  const Experiment e =
      parse_experiment(adaptive + "adaptive_gain = 0.5\nadaptive_window_cells = 7\n", "x.toml");
  const control::SurfaceOptions o = control::with_adaptive(surface_options(e, 10));
  CHECK(o.adaptive.gain == 0.5);
  CHECK(o.adaptive.window_cells == 7);
  CHECK(o.adaptive.gain_max == control::SurfaceAdaptiveOptions{}.gain_max);
  CHECK(parse_experiment(dump(e), "dump").control.extra.number("adaptive_gain") == 0.5);
  CHECK_THROWS_WITH(parse_experiment("[lab]\nkind = \"ice\"\n[ice]\nmesh = \"x.stl\"\nslice = "
                                     "\"s.toml\"\nmachine = \"m.toml\"\n[control]\nscheme = \"smf\"\n"
                                     "[control.extra]\nadaptive_gain = 0.5\n",
                                     "x.toml"),
                    Catch::Contains("is of control.scheme = \"smf_adaptive\""));
  Experiment smf;
  CHECK(dump(smf).find("adaptive_gain") == std::string::npos);
}

TEST_CASE("the declared defaults are those of the options struct") {
  control::SurfaceOptions o;
  o.extra.complete(control::kAdaptiveOptions);
  const control::SurfaceAdaptiveOptions declared = control::with_adaptive(o).adaptive, own;
  CHECK(declared.kp == own.kp);
  CHECK(declared.gain == own.gain);
  CHECK(declared.gain_min == own.gain_min);
  CHECK(declared.gain_max == own.gain_max);
  CHECK(declared.gain_rate == own.gain_rate);
  CHECK(declared.window_cells == own.window_cells);
}

}  // namespace
}  // namespace firn
