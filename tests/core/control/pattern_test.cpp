#include "core/control/pattern.h"

#include <catch2/catch.hpp>
#include <map>

#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

namespace {

Setup whole_grid(int nx, int ny) {
  Setup s;
  s.grid = {nx, ny, 0.25, 0.25, 0.0, 0.0};
  s.target = HeightMap(s.grid, 0.02);
  s.mask = Mask(s.grid, 1);
  return s;
}

ControlOptions pattern(PatternKind kind, int layers) {
  ControlOptions o;
  o.scheme = "pattern";
  o.pattern.kind = kind;
  o.pattern.layers = layers;
  return o;
}

DropletPattern layer_of(LayerController& c, const Setup& s, int layer) {
  const HeightMap flat(s.grid, 0.0);
  return c.decide({flat, layer - 1, 0, 0.0}).drops;
}

}  // namespace

TEST_CASE(
    "A random pattern fills the wanted share of the mask, differently in each layer, the same for one seed") {
  Setup s = whole_grid(60, 50);
  for (int j = 0; j < 50; ++j) s.mask.at(3, j) = 0;
  const auto a = make_controller(s, pattern(PatternKind::kRandom, 10)),
             b = make_controller(s, pattern(PatternKind::kRandom, 10));
  ControlOptions other = pattern(PatternKind::kRandom, 10);
  other.pattern.seed = 2;
  const auto c = make_controller(s, other);
  DropletPattern last;
  for (int layer = 1; layer <= 10; ++layer) {
    const DropletPattern d = layer_of(*a, s, layer);
    CHECK(double(d.total()) == Approx(0.5 * double(s.mask.count())).epsilon(0.06));
    for (int j = 0; j < 50; ++j) CHECK(d.at(3, j) == 0);
    CHECK(d == layer_of(*b, s, layer));
    CHECK(d != layer_of(*c, s, layer));
    CHECK(d != last);
    last = d;
  }
  const HeightMap flat(s.grid, 0.0);
  CHECK(a->decide({flat, 10, 0, 0.0}).kind == Decision::Kind::kEnd);
  CHECK(a->decide({flat, 9, 0, 0.0}).kind == Decision::Kind::kPrint);
}

TEST_CASE(
    "V-C: identification prints are single droplets, crosses of five and corner pairs, each on bare ground, "
    "once") {
  const Setup s = whole_grid(36, 60);
  const auto controller = make_controller(s, pattern(PatternKind::kIdentification, 4));
  const auto sites = identification_sites(s.mask, 6, 4);
  REQUIRE(sites.size() == 60);
  std::map<IdentificationSite::Kind, int> kinds;
  for (const auto& site : sites) ++kinds[site.kind];
  for (const auto& [kind, count] : kinds) CHECK(count == 20);
  DropletPattern sum(s.grid);
  for (int layer = 1; layer <= 4; ++layer) {
    const DropletPattern d = layer_of(*controller, s, layer);
    std::int64_t wanted = 0;
    for (const auto& site : sites)
      if (site.layer == layer)
        wanted += site.kind == IdentificationSite::Kind::kSingle ? 1
                  : site.kind == IdentificationSite::Kind::kSide ? 5
                                                                 : 2;
    CHECK(d.total() == wanted);
    CHECK(wanted > 0);
    for (std::size_t c = 0; c < d.size(); ++c) sum.cells[c] = std::uint8_t(sum.cells[c] + d.cells[c]);
  }
  CHECK(sum.passes() == 1);
  for (const auto& site : sites) {  // at least two bare cells between two sites
    for (int y = -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x)
        if ((std::abs(x) > 1 || std::abs(y) > 1) && std::abs(x) < 4 && std::abs(y) < 4 &&
            s.grid.contains(site.i + x, site.j + y))
          CHECK(sum.at(site.i + x, site.j + y) == 0);
    int drops = 0;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) drops += sum.at(site.i + x, site.j + y);
    CHECK(drops == (site.kind == IdentificationSite::Kind::kSingle ? 1
                    : site.kind == IdentificationSite::Kind::kSide ? 5
                                                                   : 2));
  }
}

TEST_CASE("III-A: squares of every size stand apart, their droplets a step apart") {
  const Setup s = whole_grid(90, 70);
  const auto controller = make_controller(s, pattern(PatternKind::kSquares, 1));
  const auto squares = square_sites(s.mask, 6, 2, 6);
  std::map<int, int> sizes;
  std::int64_t droplets = 0;
  for (const SquareSite& q : squares) {
    ++sizes[q.n];
    droplets += q.n * q.n;
    CHECK(q.i >= 6);
    CHECK(q.i + q.side_cells() + 6 <= s.grid.nx);
    CHECK(q.j + q.side_cells() + 6 <= s.grid.ny);
  }
  CHECK(sizes.size() == 6);
  const DropletPattern d = layer_of(*controller, s, 1);
  CHECK(d.total() == droplets);
  CHECK(d.passes() == 1);
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i + 1 < s.grid.nx; ++i) CHECK(d.at(i, j) + d.at(i + 1, j) < 2);
}

TEST_CASE("Pattern options out of range and parts too small are named") {
  const Setup s = whole_grid(20, 20);
  ControlOptions o = pattern(PatternKind::kRandom, -1);
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("layers = -1"));
  o.pattern.layers = 1;
  o.pattern.fill = 0.0;
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("fill"));
  o.pattern.fill = 0.5;
  o.pattern.largest_square = 65;
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("largest_square = 65"));
  CHECK_THROWS_WITH(make_controller(whole_grid(2, 2), pattern(PatternKind::kIdentification, 1)),
                    Catch::Contains("no room"));
  CHECK_THROWS_WITH(make_controller(whole_grid(4, 4), pattern(PatternKind::kSquares, 1)),
                    Catch::Contains("no room"));
}

TEST_CASE(
    "V-C: printed one by one, five layers have one droplet of a site each and are its droplets together") {
  const Setup s = whole_grid(36, 60);
  ControlOptions options = pattern(PatternKind::kIdentification, 4);
  const auto at_once = make_controller(s, options);
  options.pattern.one_by_one = OnOff::kOn;
  const auto one_by_one = make_controller(s, options);
  for (int of_sites = 1; of_sites <= 4; ++of_sites) {
    DropletPattern sum(s.grid);
    for (int n = 1; n <= kSiteDroplets; ++n) {
      const DropletPattern d = layer_of(*one_by_one, s, kSiteDroplets * (of_sites - 1) + n);
      for (const auto& site : identification_sites(s.mask, 6, 4)) {
        int droplets = 0;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) droplets += d.at(site.i + i, site.j + j);
        CHECK(droplets <= 1);
        if (n == 1) CHECK(droplets == int(site.layer == of_sites));
      }
      for (std::size_t c = 0; c < d.size(); ++c) sum.cells[c] = std::uint8_t(sum.cells[c] + d.cells[c]);
    }
    CHECK(sum == layer_of(*at_once, s, of_sites));
  }
  CHECK(one_by_one->decide({HeightMap(s.grid, 0.0), 20, 0, 0.0}).kind == Decision::Kind::kEnd);
}
