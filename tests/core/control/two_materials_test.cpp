// Printing a block of two inks: who decides which ink where, and whether MPC's fast objective is Eq. (8) with
// Eq. (7).
#include <catch2/catch.hpp>
#include <cmath>

#include "core/control/mpc/mpc.h"
#include "core/control/open_loop.h"
#include "core/control/prediction.h"
#include "core/control/smf.h"
#include "core/grid/solids.h"

using namespace firn;
using namespace firn::control;

namespace {

const deposition::DropletModel kSupport{3.6e-3, 0.8e-3, 0.3e-3};

// A random M: each column has up to two spans.
std::shared_ptr<const Geometry> random_geometry(const GridSpec& g, double height_mm, RandomStream& random) {
  std::vector<std::vector<Span>> spans(g.size());
  for (auto& column : spans) {
    double z = 0.0;
    for (std::uint32_t n = random.below(3); n > 0; --n) {
      const double from = z + random.uniform(0.01, 0.3) * height_mm,
                   to = from + random.uniform(0.01, 0.3) * height_mm;
      if (to > height_mm) break;
      column.push_back({from, to});
      z = to;
    }
  }
  return std::make_shared<const Geometry>(g, height_mm, spans);
}

Setup random_setup(RandomStream& random, int nx, int ny) {
  const GridSpec g{nx, ny};
  Setup s{g,
          HeightMap(g, 0.1),
          Mask(g),
          {},
          random.below(2) ? deposition::Border::kLose : deposition::Border::kKeep,
          random.bits(),
          random_geometry(g, 0.1, random),
          kSupport};
  for (auto& m : s.mask.cells) m = random.below(5) != 0;
  s.mask.cells[0] = 1;
  return s;
}

HeightMap random_surface(const GridSpec& g, RandomStream& random) {
  HeightMap h(g);
  for (double& v : h.cells) v = random.uniform(0.085, 0.1);
  return h;
}

// Eq. (8) by the full two-ink model, layer by layer, nothing incremental.
double full_objective(const Setup& s, const HeightMap& height, const std::vector<DropletPattern>& plan,
                      const std::vector<MaterialMap>& inks, double alpha) {
  deposition::TwoMaterialChange model(s.grid, {s.model, s.model_b}, s.border);
  HeightMap h = height;
  for (std::size_t n = 0; n < plan.size(); ++n) model.deposit(h, plan[n], inks[n]);
  return objective_mm(h, s.target, s.mask, alpha);
}

Setup block_setup(int n, double height_mm) {
  const GridSpec g{n, n, 0.25, 0.25, 0.0, 0.0};
  SolidSpec ellipsoid;
  ellipsoid.kind = "ellipsoid";
  ellipsoid.outer_diameter_mm = 0.6 * n * 0.25;
  ellipsoid.height_mm = 0.6 * height_mm;
  ellipsoid.centre_z_mm = 0.5 * height_mm;
  return {g,
          HeightMap(g, height_mm),
          Mask(g, 1),
          {},
          deposition::Border::kLose,
          7,
          std::make_shared<const Geometry>(Geometry::sampled(*make_solid(ellipsoid, g), g, height_mm, 0.002)),
          kSupport};
}

}  // namespace

TEST_CASE(
    "I_A and I_B follow the measured height: a cell is object where its surface lies in M (Lu 2015, IV-B)") {
  RandomStream random(201, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    Setup s = random_setup(random, 9, 7);
    HeightMap h(s.grid);
    for (double& v : h.cells) v = random.uniform(0.0, 0.1);
    ControlOptions o;
    for (const char* scheme : {"mpc", "smf", "threshold"}) {
      o.scheme = scheme;
      const Decision d = make_controller(s, o)->decide({h, 5, 0, 0.0});
      REQUIRE(d.materials.size() == s.grid.size());
      for (std::size_t n = 0; n < h.size(); ++n) {
        bool inside = false;  // brute force: the spans, one by one
        for (const Span& span : s.geometry->spans(n))
          inside = inside || (h.cells[n] >= span.from_mm && h.cells[n] < span.to_mm);
        const Material expected = !s.mask.cells[n] ? Material::kNone : inside ? Material::kA : Material::kB;
        CHECK(d.materials.of(n) == expected);
      }
    }
  }
}

TEST_CASE("Open loop assumes layers of a fixed height: its inks ignore what was measured (Lu 2015, V-A)") {
  const Setup s = block_setup(15, 0.076);
  OpenLoop open(s, ControlOptions{});
  CHECK(open.layers() == 10);
  const HeightMap low(s.grid, 0.0), high(s.grid, 0.07);
  for (int layer = 0; layer < 10; ++layer) {
    const Decision a = open.decide({low, layer, 0, 0.0}), b = open.decide({high, layer, 0, 0.0});
    CHECK(a.materials == b.materials);
    for (std::size_t c = 0; c < s.grid.size(); ++c)
      CHECK(a.materials.of(c) == s.geometry->at(c, layer * 0.0076));
  }
}

TEST_CASE("Inks judged half a layer above the surface are those of the droplet's middle, in every scheme") {
  Setup s = block_setup(15, 0.076);
  s.judge_above_mm = 0.0038;
  RandomStream random(205, Purpose::kTest);
  HeightMap h(s.grid);
  for (double& v : h.cells) v = random.uniform(0.0, 0.076);
  ControlOptions o;
  for (const char* scheme : {"mpc", "smf", "threshold", "open_loop"}) {
    o.scheme = scheme;
    const Decision d = make_controller(s, o)->decide({h, 4, 0, 0.0});
    for (std::size_t c = 0; c < h.size(); ++c) {
      const double surface = o.scheme == "open_loop" ? 4 * 0.0076 : h.cells[c];
      CHECK(d.materials.of(c) == s.geometry->at(c, surface + 0.0038));
    }
  }
  s.judge_above_mm = -1.0;
  CHECK_THROWS_WITH(make_controller(s, o), Catch::Contains("judge_above_mm"));
}

TEST_CASE("One ink: decisions carry no materials") {
  Setup s = block_setup(9, 0.05);
  s.geometry = nullptr;
  ControlOptions o;
  for (const char* scheme : {"open_loop", "smf", "mpc"}) {
    o.scheme = scheme;
    CHECK(make_controller(s, o)->decide({HeightMap(s.grid), 0, 0, 0.0}).materials.size() == 0);
  }
}

TEST_CASE(
    "Eq. (8) with Eq. (7): the incremental objective of two inks is the full model's, for every horizon") {
  RandomStream random(202, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    const int horizon = 1 + int(random.below(3)), max_drops = 1 + int(random.below(2));
    const Setup s = random_setup(random, 6 + int(random.below(6)), 5 + int(random.below(6)));
    const HeightMap h = random_surface(s.grid, random);
    const double alpha = random.below(3) ? random.uniform(0.3, 1.0) : 1.0;
    std::vector<MaterialMap> inks;
    std::vector<DropletPattern> plan(std::size_t(horizon), DropletPattern(s.grid));
    for (auto& layer : plan) {
      inks.push_back(materials_at(s, h, double(inks.size()) * 0.0076));
      for (std::size_t c = 0; c < s.grid.size(); ++c)
        if (s.mask.cells[c]) layer.cells[c] = std::uint8_t(random.below(std::uint32_t(max_drops) + 1));
    }
    mpc::HorizonObjective objective(s, horizon, max_drops);
    objective.set_surface(h, alpha, inks);
    objective.set_plan(plan);
    CHECK(objective.value_mm() == Approx(full_objective(s, h, plan, inks, alpha)).margin(1e-14));
    for (int n = 0; n < 30; ++n) {
      const auto cells = objective.part_cells();
      const mpc::Move move{int(random.below(std::uint32_t(horizon))),
                           cells[random.below(std::uint32_t(cells.size()))], random.below(2) ? 1 : -1};
      if (!objective.allowed(move)) continue;
      const double before = objective.value_mm(), gain = objective.gain_mm(move);
      auto& count = plan[std::size_t(move.layer)].cells[move.cell];
      count = std::uint8_t(count + move.change);
      CHECK(before + gain == Approx(full_objective(s, h, plan, inks, alpha)).margin(1e-13));
      objective.apply(move);
      CHECK(objective.value_mm() == Approx(before + gain).margin(1e-14));
    }
  }
}

TEST_CASE("MPC of two inks with the same constants prints what MPC of one ink prints") {
  RandomStream random(203, Purpose::kTest);
  for (int trial = 0; trial < 10; ++trial) {
    Setup two = random_setup(random, 14, 11);
    two.model_b = two.model;
    Setup one = two;
    one.geometry = nullptr;
    ControlOptions o;
    o.mpc.alpha = {{1, 0.6}};
    const HeightMap h = random_surface(two.grid, random);
    const Decision a = Mpc(two, o).decide({h, 3, 0, 0.0}), b = Mpc(one, o).decide({h, 3, 0, 0.0});
    CHECK(a.drops == b.drops);
    CHECK(a.objective_mm == Approx(b.objective_mm).margin(1e-15));
    CHECK(a.kind == b.kind);
  }
}

TEST_CASE(
    "MPC's decision for two inks scores as predicted, is optimal droplet by droplet, and is reproducible") {
  RandomStream random(204, Purpose::kTest);
  const Setup s = random_setup(random, 20, 17);
  const HeightMap h = random_surface(s.grid, random);
  ControlOptions o;
  o.mpc.alpha = {{1, 0.5}};
  const Decision d = Mpc(s, o).decide({h, 3, 0, 0.0}), again = Mpc(s, o).decide({h, 3, 0, 0.0});
  REQUIRE(d.kind == Decision::Kind::kPrint);
  CHECK(d.drops == again.drops);
  CHECK(d.materials == again.materials);
  CHECK(d.objective_mm == Approx(full_objective(s, h, {d.drops}, {d.materials}, 0.5)).margin(1e-14));
  for (std::size_t c = 0; c < s.grid.size(); ++c) {
    if (!s.mask.cells[c]) continue;
    DropletPattern other = d.drops;
    other.cells[c] = other.cells[c] ? 0 : 1;
    CHECK(full_objective(s, h, {other}, {d.materials}, 0.5) > d.objective_mm - 1e-12);
  }
}

TEST_CASE("Closed loop of two inks brings both to the same height, the smaller droplets of ink B included") {
  const Setup s = block_setup(21, 0.0912);
  ControlOptions o;
  o.mpc.alpha = {{1, 0.5}};
  o.max_layers = 40;
  for (const char* scheme : {"mpc", "smf"}) {
    o.scheme = scheme;
    const auto controller = make_controller(s, o);
    deposition::TwoMaterialChange nature(s.grid, {s.model, s.model_b}, s.border);
    HeightMap h(s.grid);
    int layer = 0;
    for (;; ++layer) {
      const Decision d = controller->decide({h, layer, 0, 0.0});
      REQUIRE(d.kind != Decision::Kind::kStop);
      if (d.kind == Decision::Kind::kEnd) break;
      nature.deposit(h, d.drops, d.materials);
    }
    const ErrorStats e = error_stats(h, s.target, s.mask);
    INFO(scheme << ": " << e.mean_mm << " mm, rms " << e.rms_mm << " mm after " << layer << " layers");
    CHECK(layer >= 12);
    CHECK(e.mean_abs_mm < 3e-3);
  }
}

TEST_CASE("A geometry of another grid is refused, and so are two inks by the patterns to learn from") {
  Setup s = block_setup(9, 0.05);
  ControlOptions pattern;
  pattern.scheme = "pattern";
  CHECK_THROWS_WITH(make_controller(s, pattern), Catch::Contains("one ink"));
  s.geometry = block_setup(10, 0.05).geometry;
  CHECK_THROWS_WITH(make_controller(s, ControlOptions{}), Catch::Contains("geometry"));
}
