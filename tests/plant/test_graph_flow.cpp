// The graph nature: conservation, its linear form, and its limits.
#include <catch2/catch.hpp>

#include <map>

#include "core/deposition/height_change.h"
#include "core/grid/random.h"
#include "plant/inkjet/model.h"

using namespace firn;
using namespace firn::plant;

namespace {

const GridSpec kNodes{9, 8, 0.263256, 0.263256, 0.0, 0.0};

WorldConfig graph_flow() {
  WorldConfig c;
  c.model = "graph_flow";
  c.grid = kNodes;
  c.droplet.size_scatter = c.droplet.missed_probability = 0.0;
  c.nozzle.drift = false;
  return c;
}

void drop_at(Model& model, int i, int j) { model.fire({0, kNodes.x_mm(i), kNodes.y_mm(j), 0.0, 0.0}); }

double sum_mm(const HeightMap& h) {
  double sum = 0.0;
  for (const double z : h.cells) sum += z;
  return sum;
}

}  // namespace

TEST_CASE("Graph flow conserves volume to 1e-12, whatever flows where") {
  RandomStream random(5, Purpose::kTest);
  for (int draw = 0; draw < 20; ++draw) {
    WorldConfig c = graph_flow();
    c.droplet.cure_shrink = 0.5 * random.uniform();
    c.nature.graph_flow = {0.2 * random.uniform(),  0.04 * random.uniform(),       0.1 * random.uniform(),
                           0.1 * random.uniform(),  1e-4 + 0.1 * random.uniform(), int(random.below(60)),
                           1 + int(random.below(4))};
    const auto model = make_model(c);
    for (int layer = 0; layer < 6; ++layer) {
      for (int n = 0; n < 80; ++n) drop_at(*model, int(random.below(11)) - 1, int(random.below(10)) - 1);
      model->end_pass();
      model->expose(layer);
    }
    const VolumeLedger l = model->ledger();
    CHECK(std::abs(model->volume_mm3() - (l.landed - l.lost - l.shrunk)) <= 1e-12 * l.landed);
    for (const double h : model->means_with_margin().cells) CHECK(h >= 0.0);
  }
}

TEST_CASE("Without flow, droplets on level ground add up as those of Lu do") {
  WorldConfig c = graph_flow();
  const double h1 = 4.4e-3, h2 = 0.6e-3, h3 = 0.2e-3, whole = h1 + 4 * h2 + 4 * h3;
  c.droplet.volume_mm3 = whole * kNodes.pitch_x_mm * kNodes.pitch_y_mm;
  c.droplet.cure_shrink = 0.0;
  c.nature.graph_flow = {h2 / whole, h3 / whole, 0.0, 0.0, 1.0, 0, 3};
  const auto model = make_model(c);
  DropletPattern drops(kNodes);
  for (int j = 0; j < kNodes.ny; ++j)
    for (int i = 0; i < kNodes.nx; ++i)
      if ((3 * i + j) % 4 != 0) {
        drops.at(i, j) = 1;
        drop_at(*model, i, j);
      }
  HeightMap expected(kNodes, 0.0);
  deposition::HeightChange<1>(kNodes, deposition::stencil_of({h1, h2, h3}), deposition::Border::kLose)
      .deposit(expected, drops);
  const HeightMap got = model->cell_means();
  for (std::size_t n = 0; n < got.size(); ++n) CHECK(got.cells[n] == Approx(expected.cells[n]).margin(1e-15));
}

TEST_CASE("A step of unhindered flow is v - D K D'(H + v), by its matrix") {
  WorldConfig c = graph_flow();
  // Two layers, the second all wet: nothing is dry, and the range is wide.
  c.nature.graph_flow = {0.1, 0.02, 0.03, 0.01, 10.0, 1, 1};
  const auto model = make_model(c);
  RandomStream random(6, Purpose::kTest);
  const int width = kNodes.nx + 2, depth = kNodes.ny + 2;
  std::vector<double> wet(std::size_t(width * depth), 0.0);
  const double whole = c.droplet.volume_mm3 / (kNodes.pitch_x_mm * kNodes.pitch_y_mm);
  for (int j = 0; j < kNodes.ny; ++j)
    for (int i = 0; i < kNodes.nx; ++i)
      for (int n = 0; n < 20 + int(random.below(2)); ++n) {
        drop_at(*model, i, j);
        for (int b = -1; b <= 1; ++b)
          for (int a = -1; a <= 1; ++a)
            wet[std::size_t((j + 1 + b) * width + i + 1 + a)] += whole * (a == 0 && b == 0 ? 0.52
                                                                          : a * b == 0     ? 0.1
                                                                                           : 0.02);
      }
  // The Laplacian D K D' as a sum over all ordered pairs.
  std::vector<double> expected = wet;
  for (int j = 0; j < depth; ++j)
    for (int i = 0; i < width; ++i)
      for (int b = -1; b <= 1; ++b)
        for (int a = -1; a <= 1; ++a) {
          if ((a == 0 && b == 0) || i + a < 0 || j + b < 0 || i + a >= width || j + b >= depth) continue;
          const double kappa = a * b == 0 ? 0.03 : 0.01;
          expected[std::size_t(j * width + i)] -=
              kappa * (wet[std::size_t(j * width + i)] - wet[std::size_t((j + b) * width + i + a)]);
        }
  model->end_pass();
  const HeightMap got = model->means_with_margin();
  for (std::size_t n = 0; n < got.size(); ++n) CHECK(got.cells[n] == Approx(expected[n]).epsilon(1e-12));
}

TEST_CASE("Flow levels wet ink and leaves cured ink where it is") {
  WorldConfig c = graph_flow();
  c.nature.graph_flow.steps = 200;
  c.nature.graph_flow.kappa_side = 0.1;
  c.droplet.cure_shrink = 0.0;
  const auto model = make_model(c);
  drop_at(*model, 4, 4);
  model->end_pass();
  const HeightMap wet = model->means_with_margin();
  CHECK(*std::max_element(wet.cells.begin(), wet.cells.end()) < 2.0 * sum_mm(wet) / double(wet.size()));
  model->expose(0);
  drop_at(*model, 0, 0);
  const HeightMap cured = model->means_with_margin();
  model->expose(1);
  for (std::size_t n = 0; n < wet.size(); ++n) CHECK(cured.cells[n] >= wet.cells[n] - 1e-15);
}

TEST_CASE("Reading the surface of a graph world twice moves nothing") {
  const auto once = make_model(graph_flow()), twice = make_model(graph_flow());
  for (const auto& model : {once.get(), twice.get()})
    for (int n = 0; n < 30; ++n) {
      drop_at(*model, n % 9, n % 7);
      if (model == twice.get()) model->cell_means();
    }
  CHECK(twice->cell_means().cells == once->cell_means().cells);
  once->end_pass();
  twice->end_pass();
  CHECK(twice->cell_means().cells == once->cell_means().cells);
}
