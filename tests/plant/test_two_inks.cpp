#include <catch2/catch.hpp>
#include <filesystem>

#include "core/deposition/two_materials.h"
#include "core/grid/random.h"
#include "plant/inkjet/model.h"
#include "plant/world/setup.h"

using namespace firn;
using namespace firn::plant;

namespace {

WorldConfig two_inks(double variation) {
  WorldConfig c;
  c.model = "lu2015";
  c.grid = {14, 11, 0.263256, 0.263256, 0.0, 0.0};
  c.two_inks = true;
  c.ratio_b = 0.9;
  c.lu2015.variation = variation;
  return c;
}

struct Layer {
  DropletPattern drops;
  MaterialMap inks;
  Layer(const GridSpec& g, RandomStream& random) : drops(g), inks(g) {
    for (auto& d : drops.cells) d = std::uint8_t(random.below(3));
    for (auto& m : inks.cells) m = std::uint8_t(1 + random.below(2));
  }
};

// As the lab does it: in each pass the object's jet first, then the support's, each armed and disarmed.
void print(Model& model, const Layer& layer, const GridSpec& g) {
  for (int pass = 0; pass < layer.drops.passes(); ++pass)
    for (const Material ink : {Material::kA, Material::kB}) {
      for (int j = 0; j < g.ny; ++j)
        for (int i = 0; i < g.nx; ++i)
          if (layer.drops.at(i, j) > pass && Material(layer.inks.at(i, j)) == ink)
            model.fire({0, g.x_mm(i), g.y_mm(j), 0.0, 0.0, ink});
      model.end_pass();
    }
}

}  // namespace

TEST_CASE(
    "lu2015 with two inks and without variation is Eq. (7): both jets' droplets meet the same surface") {
  const WorldConfig c = two_inks(0.0);
  const auto model = make_model(c);
  const deposition::DropletModel a, b{0.9 * a.h1_mm, 0.9 * a.h2_mm, 0.9 * a.h3_mm};
  deposition::TwoMaterialChange eq7(c.grid, {a, b}, deposition::Border::kLose);
  HeightMap expected(c.grid);
  MaterialColumns columns(c.grid);
  RandomStream random(12, Purpose::kTest);
  for (int layer = 0; layer < 6; ++layer) {
    const Layer l(c.grid, random);
    print(*model, l, c.grid);
    eq7.deposit(expected, l.drops, l.inks, columns);
    const HeightMap wet = model->cell_means();
    for (std::size_t n = 0; n < wet.size(); ++n)
      CHECK(wet.cells[n] == Approx(expected.cells[n]).margin(1e-15));
    const MaterialColumns pending = model->materials();
    model->expose(layer);
    model->measured();
    const MaterialColumns settled = model->materials();
    for (std::size_t n = 0; n < c.grid.size(); ++n) {
      CHECK(settled.top_mm(n) == Approx(columns.top_mm(n)).margin(1e-12));
      CHECK(pending.top_mm(n) == settled.top_mm(n));
      CHECK(settled.column(n).size() == columns.column(n).size());
    }
  }
  const VolumeLedger l = model->ledger();
  CHECK(l.landed - l.lost == Approx(model->volume_mm3()).epsilon(1e-12));
}

TEST_CASE("One ink in a world of two is the world of one, to the last bit, and its columns are all object") {
  WorldConfig c = two_inks(0.2), one = c;
  one.two_inks = false;
  const auto two_inks = make_model(c), one_ink = make_model(one);
  RandomStream random(13, Purpose::kTest);
  for (int layer = 0; layer < 4; ++layer) {
    Layer l(c.grid, random);
    for (auto& m : l.inks.cells) m = std::uint8_t(Material::kA);
    for (Model* m : {two_inks.get(), one_ink.get()}) {
      print(*m, l, c.grid);
      m->expose(layer);
      m->measured();
    }
  }
  CHECK(two_inks->cell_means().cells == one_ink->cell_means().cells);
  CHECK(one_ink->materials().empty());
  const MaterialColumns columns = two_inks->materials();
  for (std::size_t n = 0; n < c.grid.size(); ++n) {
    REQUIRE(columns.column(n).size() == 1);
    CHECK(columns.column(n)[0].material == Material::kA);
  }
}

TEST_CASE("A saved world of two inks goes on with the same columns") {
  const WorldConfig c = two_inks(0.2);
  const auto first = make_model(c), second = make_model(c);
  RandomStream random(14, Purpose::kTest);
  const Layer one(c.grid, random), two(c.grid, random);
  print(*first, one, c.grid);
  Archive out;
  first->io(out);
  Archive in(out.bytes());
  second->io(in);
  in.expect_end();
  for (Model* m : {first.get(), second.get()}) {
    m->expose(0);
    m->measured();
    print(*m, two, c.grid);
  }
  const MaterialColumns a = first->materials(), b = second->materials();
  for (std::size_t n = 0; n < c.grid.size(); ++n) {
    REQUIRE(a.column(n).size() == b.column(n).size());
    for (std::size_t s = 0; s < a.column(n).size(); ++s) {
      CHECK(a.column(n)[s].top_mm == b.column(n)[s].top_mm);
      CHECK(a.column(n)[s].material == b.column(n)[s].material);
    }
  }
}
