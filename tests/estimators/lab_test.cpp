// The laboratory's estimation: closed forms of a linear simulator, planted maps, a box's known minimum.
#include <catch2/catch.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

#include "core/grid/random.h"
#include "estimators/lab/box_search.h"
#include "estimators/lab/layer_features.h"
#include "estimators/lab/synthetic_likelihood.h"

using namespace firn;
using namespace firn::lab;

namespace {

// s_0 = 1 + 2 z_0 + e, s_1 = z_1 + 0.5 z_0 + 0.3 e', s_2 = e'': a simulator with a posterior in closed form.
std::vector<double> linear_simulator(std::span<const double> z, RandomStream& random) {
  return {1.0 + 2.0 * z[0] + random.normal(), z[1] + 0.5 * z[0] + 0.3 * random.normal(), random.normal()};
}

Simulations simulated(std::size_t rows, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  Simulations sims{2, 3, {}, {}};
  for (std::size_t n = 0; n < rows; ++n) {
    const std::vector<double> z{random.normal(), random.normal()};
    sims.add(z, linear_simulator(z, random));
  }
  return sims;
}

const std::vector<std::size_t> kAll{0, 1, 2};

droplet::PrintedLayer layer_of(const GridSpec& grid, double before_mm, double rise_mm) {
  droplet::PrintedLayer l{DropletPattern(grid), HeightMap(grid, before_mm),
                          HeightMap(grid, before_mm + rise_mm),
                          std::vector<droplet::Use>(grid.size(), droplet::Use::kLearn)};
  std::ranges::fill(l.fired.cells, std::uint8_t{1});
  return l;
}

struct Part {
  GridSpec grid{12, 12, 0.26, 0.26, 0.0, 0.0};
  Mask mask{grid, 1};
  HeightMap target{grid, 0.09};
  std::vector<droplet::PrintedLayer> layers;
  Part() {
    for (std::size_t n = 0; n < 9; ++n) layers.push_back(layer_of(grid, 0.01 * double(n), 0.01));
  }
  std::vector<double> features() const { return layer_features({layers, mask, target, 0.001}); }
};

std::size_t index_of(const std::string& name) {
  for (std::size_t f = 0; f < feature_count(); ++f)
    if (feature_name(f) == name) return f;
  FAIL("no feature " << name);
  return 0;
}

}  // namespace

TEST_CASE("The posterior of a linear simulator is the one of its closed form") {
  const Simulations sims = simulated(20'000, 1);
  const std::vector<double> observed{2.0, -1.0, 0.3};
  const Normal p = SyntheticLikelihood(sims).posterior(observed, kAll);
  Eigen::Matrix<double, 2, 2> b;
  b << 2.0, 0.0, 0.5, 1.0;
  const Eigen::Vector2d noise(1.0, 0.09), d(1.0, -1.0);
  const Eigen::Matrix2d information =
      b.transpose() * noise.cwiseInverse().asDiagonal() * b + Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d covariance = information.inverse();
  const Eigen::Vector2d mean = covariance * b.transpose() * noise.cwiseInverse().asDiagonal() * d;
  for (int n = 0; n < 2; ++n) {
    CHECK(p.mean[std::size_t(n)] == Approx(mean[n]).margin(0.02));
    CHECK(p.std(std::size_t(n)) == Approx(std::sqrt(covariance(n, n))).epsilon(0.03));
  }
}

TEST_CASE("A prior that is doubted pulls a far simulator less, and its posterior is wider") {
  const SyntheticLikelihood likelihood(simulated(20'000, 1));
  const std::vector<double> observed{2.0, -1.0, 0.3};
  const Normal usual = likelihood.posterior(observed, kAll),
               doubted = likelihood.posterior(observed, kAll, 1.5);
  // Precisions add: the doubted posterior's is less by 1 - 1 / 1.5^2 on each axis.
  const auto determinant = [](const Normal& n, double more) {
    const double all = n.covariance[0] * n.covariance[3] - n.covariance[1] * n.covariance[2];
    return (n.covariance[3] / all + more) * (n.covariance[0] / all + more) -
           n.covariance[1] * n.covariance[2] / (all * all);
  };
  CHECK(determinant(doubted, 1.0 - 1.0 / 2.25) == Approx(determinant(usual, 0.0)));
  for (std::size_t n = 0; n < 2; ++n) {
    CHECK(doubted.std(n) > usual.std(n));
    CHECK(std::abs(doubted.mean[n]) > std::abs(usual.mean[n]));
  }
}

TEST_CASE("Posterior intervals of a simulator cover its parameters as often as they say") {
  const SyntheticLikelihood likelihood(simulated(120, 2));
  RandomStream random(3, Purpose::kTest);
  int covered = 0;
  const int trials = 2000;
  for (int n = 0; n < trials; ++n) {
    const std::vector<double> z{random.normal(), random.normal()};
    const Normal p = likelihood.posterior(linear_simulator(z, random), kAll);
    for (std::size_t k = 0; k < 2; ++k) covered += std::abs(z[k] - p.mean[k]) <= 1.96 * p.std(k);
  }
  CHECK(double(covered) / (2.0 * trials) > 0.92);
  CHECK(double(covered) / (2.0 * trials) < 0.98);
}

TEST_CASE("A feature beyond anything that the simulator does deviates beyond all simulations") {
  const Simulations sims = simulated(150, 4);
  const SyntheticLikelihood likelihood(sims);
  const auto within = likelihood.largest_deviations(kAll);
  const std::vector<double> usual{1.5, 0.2, -0.4}, strange{1.5, 0.2, 9.0};
  const auto of = [&](const std::vector<double>& s) {
    double largest = 0.0;
    for (const double d : likelihood.deviations(s, likelihood.posterior(s, kAll)))
      largest = std::max(largest, std::abs(d));
    return largest;
  };
  CHECK(of(usual) < *std::ranges::max_element(within));
  CHECK(of(strange) > 1.5 * *std::ranges::max_element(within));
}

TEST_CASE("Features that contradict each other deviate together where none deviates alone") {
  // The features hold the parameter with one error in common.
  Simulations sims{1, 5, {}, {}};
  RandomStream random(12, Purpose::kTest);
  const auto simulated_print = [&](double z) {
    const double common = random.normal();
    std::vector<double> s(4);
    for (double& v : s) v = 0.5 * z + common + 0.1 * random.normal();
    s.push_back(std::log(13.0));  // the same in every print
    return s;
  };
  for (int n = 0; n < 80; ++n) {
    const double z = random.normal();
    sims.add(std::vector<double>{z}, simulated_print(z));
  }
  const SyntheticLikelihood likelihood(sims);
  const std::vector<std::size_t> all{0, 1, 2, 3, 4};
  const Normal usual = standard_normal(1);
  const std::vector<double> simulated_ones = likelihood.joint_deviations(all);
  const double most = *std::ranges::max_element(simulated_ones);
  int beyond = 0;
  for (int n = 0; n < 200; ++n)
    beyond += likelihood.joint_deviation(simulated_print(random.normal()), all, usual) > 1.3 * most;
  CHECK(beyond <= 4);
  const std::vector<double> strange{1.6, -1.6, 1.6, -1.6, std::log(13.0)};
  for (const double d : likelihood.deviations(strange, usual)) CHECK(std::abs(d) < 2.0);
  CHECK(likelihood.joint_deviation(strange, all, usual) > 5.0 * most);
  CHECK_THROWS_AS(likelihood.joint_deviation(strange, {}, usual), std::invalid_argument);
}

TEST_CASE(
    "A feature that no simulation moves deviates where the observed value is another, not by rounding") {
  Simulations sims{1, 2, {}, {}};
  RandomStream random(13, Purpose::kTest);
  const double layers = std::log(53.0);
  for (int n = 0; n < 60; ++n) {
    const std::vector<double> z{random.normal()};
    sims.add(z, std::vector<double>{z[0] + random.normal(), layers});
  }
  const SyntheticLikelihood likelihood(sims);
  CHECK_FALSE(likelihood.moved(1));
  CHECK(likelihood.moved(0));
  const auto of = [&](double observed) {
    return likelihood.deviations(std::vector<double>{0.3, observed}, standard_normal(1))[1];
  };
  CHECK(of(layers) == 0.0);
  CHECK(of(layers * (1.0 + 1e-9)) == 0.0);
  CHECK(of(std::log(54.0)) > 1000.0);
  CHECK(of(std::log(52.0)) < -1000.0);
}

TEST_CASE("Simulations of another length or without a number are refused, and too few of them") {
  Simulations sims{2, 3, {}, {}};
  CHECK_THROWS_WITH(sims.add(std::vector<double>{1.0}, std::vector<double>{1, 2, 3}),
                    Catch::Contains("length"));
  CHECK_THROWS_WITH(sims.add(std::vector<double>{1.0, NAN}, std::vector<double>{1, 2, 3}),
                    Catch::Contains("finite"));
  CHECK_THROWS_WITH(SyntheticLikelihood(simulated(6, 5)), Catch::Contains("6 simulations"));
}

TEST_CASE("A distribution's draws have its mean and covariance, and one more print narrows it as it says") {
  const Normal n{{1.0, -2.0}, {4.0, 1.0, 1.0, 2.0}};
  CHECK(n.at(std::vector<double>{0.0, 0.0}) == n.mean);
  RandomStream random(6, Purpose::kTest);
  double squares = 0.0, product = 0.0;
  const int draws = 20'000;
  for (int k = 0; k < draws; ++k) {
    const auto x = n.at(std::vector<double>{random.normal(), random.normal()});
    squares += (x[0] - 1.0) * (x[0] - 1.0) / draws;
    product += (x[0] - 1.0) * (x[1] + 2.0) / draws;
  }
  CHECK(squares == Approx(4.0).epsilon(0.05));
  CHECK(product == Approx(1.0).margin(0.1));
  CHECK(n.std_with(standard_normal(2), 0) == Approx(2.0));
  CHECK(n.std_with({{0.0, 0.0}, {0.25, 0.0, 0.0, 0.25}}, 1) == Approx(0.5 * std::sqrt(2.0)));
  const auto back = n.normals_of(n.at(std::vector<double>{0.7, -1.2}));
  CHECK(back[0] == Approx(0.7));
  CHECK(back[1] == Approx(-1.2));
  CHECK(n.log_determinant() == Approx(std::log(7.0)));
}

TEST_CASE("A search in a box finds the lower of two valleys within its evaluations") {
  int calls = 0;
  const auto valley = [&](std::span<const double> u) {
    ++calls;
    const auto square = [](double x) { return x * x; };
    const double far = square(u[0] - 0.85) + square(u[1] - 0.2),
                 near = square(u[0] - 0.2) + square(u[1] - 0.8);
    return std::min(far, near + 0.05);
  };
  const auto points = minimise_in_box(valley, std::vector<double>{0.2, 0.8}, 60);
  CHECK(calls <= 60);
  CHECK(points.size() == std::size_t(calls));
  const auto best = std::ranges::min_element(points, {}, &BoxPoint::value);
  CHECK(best->u[0] == Approx(0.85).margin(0.03));
  CHECK(best->u[1] == Approx(0.2).margin(0.03));
  CHECK(minimise_in_box([](std::span<const double>) { return 3.0; }, {}, 10).size() == 1);
}

TEST_CASE("A search passes on what its function throws") {
  const auto broken = [](std::span<const double> u) -> double {
    if (u[0] != 0.5) throw std::runtime_error("no print");
    return 1.0;
  };
  CHECK_THROWS_WITH(minimise_in_box(broken, std::vector<double>{0.5}, 12), "no print");
}

TEST_CASE("Features of layers hold the growth by a droplet, a tilt and a low row where they were planted") {
  Part part;
  const std::vector<double> even = part.features();
  REQUIRE(even.size() == feature_count());
  CHECK(even[index_of("growth by a droplet inside the part")] == Approx(10.0));
  CHECK(even[index_of("tilt of the surface along x")] == Approx(0.0).margin(1e-9));
  CHECK(even[index_of("number of layers")] == Approx(std::log(9.0)));

  Part tilted;  // 1 um from cell to cell along x, in every map
  for (auto& l : tilted.layers)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) {
        l.before.at(i, j) += 0.001 * i;
        l.after.at(i, j) += 0.001 * i;
      }
  CHECK(tilted.features()[index_of("tilt of the surface along x")] == Approx(12.0).epsilon(0.05));
  CHECK(tilted.features()[index_of("tilt of the surface along y")] == Approx(0.0).margin(1e-6));

  Part clogged;  // row 5 grows by half
  RandomStream random(7, Purpose::kTest);
  for (auto& l : clogged.layers)
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) l.after.at(i, j) += (j == 5 ? -0.005 : 0.0) + 0.0003 * random.normal();
  const auto low = clogged.features();
  CHECK(low[index_of("lowest row of cells")] < 3.0 * low[index_of("lowest column of cells")]);
  CHECK(low[index_of("lasting differences between cells")] > 1.5);
}

TEST_CASE("Droplets that land displaced are found along x, and along their row where rows alternate") {
  // Half of the cells get a droplet of 10 um, a fifth of which lies in the next cell.
  const auto displaced = [](bool alternate) {
    Part part;
    RandomStream random(9, Purpose::kTest);
    for (std::size_t k = 0; k < part.layers.size(); ++k) {
      auto& l = part.layers[k];
      l.before = k == 0 ? HeightMap(part.grid, 0.0) : part.layers[k - 1].after;
      l.after = l.before;
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 12; ++i) {
          l.fired.at(i, j) = std::uint8_t(random.uniform() < 0.5);
          if (!l.fired.at(i, j)) continue;
          const int next = i + (alternate && j % 2 ? -1 : 1);
          l.after.at(i, j) += 0.008;
          if (part.grid.contains(next, j)) l.after.at(next, j) += 0.002;
        }
      for (double& h : l.after.cells) h += 0.0005 * random.normal();
    }
    return part.features();
  };
  const std::size_t ahead = index_of("droplets that land ahead of the stage or behind it");
  const auto even = displaced(false), turned = displaced(true);
  CHECK(std::abs(even[ahead]) < 0.2);
  CHECK(turned[ahead] > 0.7);
  const std::size_t along_x = index_of("droplets that land displaced along x"),
                    along_row = index_of("droplets that land displaced along their row");
  CHECK(even[along_x] > 0.7);
  CHECK(std::abs(turned[along_x]) < 0.2);
  CHECK(even[along_row] > 2.0);
  CHECK(turned[along_row] > 2.0);
  CHECK(std::abs(turned[index_of("droplets that land displaced along y")]) < 0.2);
}

TEST_CASE("Features hold the shape of a droplet's response and growth that falls along a layer") {
  // Half of the cells get a droplet of 10 um: a tenth of it lies in each side cell, or in each two cells
  // away.
  const auto spread = [](int distance, double fall) {
    Part part;
    RandomStream random(4, Purpose::kTest);
    for (std::size_t k = 0; k < part.layers.size(); ++k) {
      auto& l = part.layers[k];
      l.before = k == 0 ? HeightMap(part.grid, 0.0) : part.layers[k - 1].after;
      l.after = l.before;
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 12; ++i) {
          l.fired.at(i, j) = std::uint8_t(random.uniform() < 0.5);
          if (!l.fired.at(i, j)) continue;
          const double whole_mm = 0.01 * (1.0 - fall * j / 12.0);
          l.after.at(i, j) += 0.6 * whole_mm;
          const int away[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
          for (const auto& [a, b] : away)
            if (part.grid.contains(i + distance * a, j + distance * b))
              l.after.at(i + distance * a, j + distance * b) += 0.1 * whole_mm;
        }
    }
    return part.features();
  };
  const auto near = spread(1, 0.0), far = spread(2, 0.0), falling = spread(1, 0.4);
  const std::size_t ring = index_of("growth by a droplet two cells away"),
                    sides = index_of("growth by a droplet at a side against one at a corner"),
                    rows = index_of("growth from a layer's first row to its last");
  CHECK(near[sides] > 0.3);
  CHECK(std::abs(far[sides]) < 0.1);
  CHECK(far[ring] > 0.1);
  CHECK(std::abs(near[ring]) < 0.1);
  CHECK(std::abs(near[rows]) < 0.3);
  CHECK(falling[rows] < -1.0);
}

TEST_CASE("Features of a print of five layers are refused, and unmeasured cells leave them finite") {
  Part part;
  for (auto& l : part.layers)
    for (int i = 0; i < 12; ++i) {
      l.after.at(i, 3) = kNotMeasured;
      l.use[l.after.spec.index(i, 3)] = droplet::Use::kNothing;
    }
  for (const double v : part.features()) CHECK(std::isfinite(v));
  part.layers.resize(5);
  CHECK_THROWS_WITH(part.features(), Catch::Contains("5 measured layers, at least 6"));
  part.layers.resize(1);
  CHECK_THROWS_WITH(part.features(), Catch::Contains("1 measured layer, at least 6"));
}
