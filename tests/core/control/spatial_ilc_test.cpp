#include "core/control/spatial_ilc.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"
#include "tests/core/control/closed_loop.h"

using namespace firn;
using namespace firn::control;

namespace {

const GridSpec kIlcGrid{10, 8, 0.263256, 0.263256, 0.0, 0.0};

/// K f with walls that reflect, cell by cell.
Grid<double> convolved(const Grid<double>& f, const deposition::DropletModel& model) {
  Grid<double> out(kIlcGrid);
  const auto inside = [](int i, int n) { return i < 0 ? -1 - i : i >= n ? 2 * n - 1 - i : i; };
  for (int j = 0; j < kIlcGrid.ny; ++j)
    for (int i = 0; i < kIlcGrid.nx; ++i)
      for (int b = -1; b <= 1; ++b)
        for (int a = -1; a <= 1; ++a)
          out.at(i, j) +=
              f.at(inside(i + a, kIlcGrid.nx), inside(j + b, kIlcGrid.ny)) * (a == 0 && b == 0 ? model.h1_mm
                                                                              : a * b == 0     ? model.h2_mm
                                                                                               : model.h3_mm);
  return out;
}

Grid<double> random_grid(std::uint64_t seed, double size) {
  RandomStream random(seed, Purpose::kTest);
  Grid<double> g(kIlcGrid);
  for (double& v : g.cells) v = size * random.uniform(-1.0, 1.0);
  return g;
}

Grid<double> minus(const Grid<double>& a, const Grid<double>& b) {
  Grid<double> out(kIlcGrid);
  for (std::size_t n = 0; n < out.size(); ++n) out.cells[n] = a.cells[n] - b.cells[n];
  return out;
}

double norm_of(const Grid<double>& g) {
  double sum = 0.0;
  for (const double v : g.cells) sum += v * v;
  return std::sqrt(sum);
}

/// One wave between the walls.
Grid<double> wave(int kx, int ky) {
  Grid<double> g(kIlcGrid);
  for (int j = 0; j < kIlcGrid.ny; ++j)
    for (int i = 0; i < kIlcGrid.nx; ++i)
      g.at(i, j) = std::cos(std::numbers::pi * kx * (i + 0.5) / kIlcGrid.nx) *
                   std::cos(std::numbers::pi * ky * (j + 0.5) / kIlcGrid.ny);
  return g;
}

ControlOptions ilc(double change) {
  ControlOptions o;
  o.scheme = "spatial_ilc";
  o.extra.numbers = {{"ilc_change", change}, {"ilc_effort", 0.0}};
  return o;
}

}  // namespace

TEST_CASE("The learning filter's kernel is the convolution, at each frequency") {
  const deposition::DropletModel model;
  const LearningFilter filter(kIlcGrid, model, 0.1, 0.0);
  for (int ky = 0; ky < kIlcGrid.ny; ++ky)
    for (int kx = 0; kx < kIlcGrid.nx; ++kx) {
      const Grid<double> w = wave(kx, ky), k = convolved(w, model);
      for (std::size_t n = 0; n < w.size(); ++n)
        CHECK(k.cells[n] ==
              Approx(filter.kernel_mm()[std::size_t(ky * kIlcGrid.nx + kx)] * w.cells[n]).margin(1e-15));
    }
}

TEST_CASE("Without a weight of change or effort, learning is dead beat") {
  const deposition::DropletModel model;
  LearningFilter filter(kIlcGrid, model, 0.0, 0.0);
  const Grid<double> rise = random_grid(1, 0.004), disturbance = random_grid(2, 0.002),
                     dose = random_grid(3, 1.0);
  const auto error = [&](const Grid<double>& f) {
    return minus(minus(rise, disturbance), convolved(f, model));
  };
  CHECK(norm_of(error(filter.next_dose(dose, error(dose)))) < 1e-14);
}

TEST_CASE("With a weight of change each frequency's error falls by R / (Q K^2 + R) a layer, exactly") {
  const deposition::DropletModel model;
  const double whole = model.layer_height_mm();
  for (const double change : {0.01, 0.3, 2.0}) {
    LearningFilter filter(kIlcGrid, model, change, 0.0);
    for (const auto& [kx, ky] : std::vector<std::pair<int, int>>{{0, 0}, {1, 0}, {4, 3}, {9, 7}}) {
      const Grid<double> rise = wave(kx, ky);
      const double k = filter.kernel_mm()[std::size_t(ky * kIlcGrid.nx + kx)] / whole;
      Grid<double> dose(kIlcGrid);
      double before = norm_of(rise);
      for (int layer = 0; layer < 4; ++layer) {
        dose = filter.next_dose(dose, minus(rise, convolved(dose, model)));
        const double after = norm_of(minus(rise, convolved(dose, model)));
        CHECK(after / before == Approx(change / (k * k + change)).epsilon(1e-6));
        before = after;
      }
    }
  }
}

TEST_CASE("A true kernel that is larger is learned up to the bound of its frequency, and no further") {
  const deposition::DropletModel model;
  const double change = 0.5, bound = 2.0 * (1.0 + change);  // at frequency 0
  for (const auto& [factor, converges] :
       std::vector<std::pair<double, bool>>{{0.3, true}, {bound * 0.98, true}, {bound * 1.02, false}}) {
    LearningFilter filter(kIlcGrid, model, change, 0.0);
    const Grid<double> rise = wave(0, 0);
    Grid<double> dose(kIlcGrid);
    for (int layer = 0; layer < 200; ++layer)
      dose = filter.next_dose(dose, minus(rise, convolved(dose, model.times(factor))));
    CHECK((norm_of(minus(rise, convolved(dose, model.times(factor)))) < norm_of(rise)) == converges);
  }
}

TEST_CASE("The next dose minimises the weighted sum of error, change and effort") {
  const deposition::DropletModel model;
  const double change = 0.2, effort = 0.05, whole = model.layer_height_mm();
  LearningFilter filter(kIlcGrid, model, change, effort);
  const Grid<double> dose = random_grid(4, 1.0), error = random_grid(5, 0.005);
  const Grid<double> best = filter.next_dose(dose, error);
  const auto cost = [&](const Grid<double>& f) {
    const Grid<double> step = minus(f, dose);
    return std::pow(norm_of(minus(error, convolved(step, model))), 2) +
           whole * whole * (change * std::pow(norm_of(step), 2) + effort * std::pow(norm_of(f), 2));
  };
  for (std::uint64_t n = 0; n < 30; ++n) CHECK(cost(minus(best, random_grid(10 + n, 1e-3))) > cost(best));
}

TEST_CASE("spatial_ilc prints a part under variation as a scheme with feedback does, and ends") {
  const Setup s = cylinder_setup();
  const auto closed = make_controller(s, ilc(0.1));
  HeightMap h(s.grid);
  RandomStream random(6, Purpose::kTest);
  Decision d;
  int layer = 0;
  for (; layer < 150; ++layer) {
    d = closed->decide({h, layer, 0, 0.0003});
    if (d.kind != Decision::Kind::kPrint) break;
    Predictor truth(s);
    const HeightMap after = truth.after(h, d.drops);
    for (std::size_t c = 0; c < h.size(); ++c)  // 10 % more than the model, with scatter
      h.cells[c] += (after.cells[c] - h.cells[c]) * (1.1 + 0.1 * random.uniform(-1.0, 1.0));
  }
  CHECK(d.kind == Decision::Kind::kEnd);
  CHECK(error_stats(h, s.target, s.mask).rms_mm < s.model.layer_height_mm());
}

TEST_CASE("spatial_ilc decides a layer that is measured again as if the first time had not been") {
  const Setup s = cylinder_setup();
  const auto once = make_controller(s, ilc(0.1)), twice = make_controller(s, ilc(0.1));
  HeightMap flat(s.grid), wrong(s.grid), right(s.grid);
  for (double& v : wrong.cells) v = 0.02;
  for (double& v : right.cells) v = 0.0065;
  for (const auto& c : {once.get(), twice.get()}) c->decide({flat, 0, 0, 0.0});
  twice->decide({wrong, 1, 0, 0.0});
  CHECK(twice->decide({right, 1, 1, 0.0}).drops == once->decide({right, 1, 0, 0.0}).drops);
}

TEST_CASE("spatial_ilc refuses weights that are none") {
  const Setup s = cylinder_setup();
  CHECK_THROWS_WITH(make_controller(s, ilc(-1.0)), Catch::Contains("ilc_change"));
}
