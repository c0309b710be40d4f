#include "estimators/droplet/height_filter.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/estimators/planted.h"

using namespace firn;
using namespace firn::droplet;
using firn::test::Planted;

namespace {

// (1 + v U[0,1]) / (1 + v / 2) has this relative standard deviation.
double scatter_of(double variation) { return variation / std::sqrt(12.0) / (1.0 + 0.5 * variation); }

HeightFilter filter_for(const Planted& world, double scatter) {
  return HeightFilter(world.grid, {world.model, deposition::Border::kLose, scatter});
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t c = 0; c < a.size(); ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return std::sqrt(sum / double(a.size()));
}

// The full Kalman filter: all covariances, Jacobian by differences.
struct Dense {
  GridSpec grid;
  deposition::DropletModel model;
  double scatter, noise;
  Eigen::VectorXd x;
  Eigen::MatrixXd p;

  HeightMap step(const HeightMap& h, const std::vector<std::uint32_t>& cells) const {
    HeightMap out = h;
    std::vector<std::uint8_t> drops(grid.size(), 0);
    for (const auto c : cells) drops[c] = 1;
    deposition::HeightChange<1>(grid, deposition::stencil_of(model), deposition::Border::kLose)
        .step(out.data(), drops.data(), 0);
    return out;
  }
  Eigen::VectorXd rise(const Eigen::VectorXd& at, const std::vector<std::uint32_t>& cells) const {
    HeightMap h(grid);
    for (std::size_t c = 0; c < grid.size(); ++c) h.cells[c] = at[Eigen::Index(c)];
    const HeightMap after = step(h, cells);
    Eigen::VectorXd out(at.size());
    for (std::size_t c = 0; c < grid.size(); ++c) out[Eigen::Index(c)] = after.cells[c] - h.cells[c];
    return out;
  }
  void layer(const std::vector<std::uint32_t>& cells, const HeightMap& map) {
    const Eigen::Index n = x.size();
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(n, n), q = Eigen::MatrixXd::Zero(n, n);
    const double d =
        std::max(2.0 * std::sqrt(p.diagonal().mean()), 1e-7);  // about as far as the surface is uncertain
    for (Eigen::Index c = 0; c < n; ++c) {
      Eigen::VectorXd up = x, down = x;
      up[c] += d;
      down[c] -= d;
      jacobian.col(c) += (rise(up, cells) - rise(down, cells)) / (2.0 * d);
    }
    for (const auto c : cells) {  // each droplet's size is its own
      const Eigen::VectorXd g = rise(x, {c});
      q += scatter * scatter * g * g.transpose();
    }
    x += rise(x, cells);
    p = jacobian * p * jacobian.transpose() + q;
    const Eigen::MatrixXd s = p + noise * noise * Eigen::MatrixXd::Identity(n, n);
    const Eigen::MatrixXd k = p * s.inverse();
    Eigen::VectorXd z(n);
    for (std::size_t c = 0; c < grid.size(); ++c) z[Eigen::Index(c)] = map.cells[c];
    x += k * (z - x);
    p = (Eigen::MatrixXd::Identity(n, n) - k) * p;
  }
};

}  // namespace

TEST_CASE("Variances and heights stay near those of the Kalman filter with all covariances") {
  for (const double variation : {0.2, 0.4})
    for (const double noise : {0.0003, 0.001}) {
      Planted world;
      world.grid = {7, 6, 0.25, 0.25, 0.0, 0.0};
      world.height = HeightMap(world.grid, 0.0);
      world.model = {4.8e-3, 0.7e-3, 0.22e-3};
      world.variation = variation;
      world.noise_mm = noise;
      world.fill = 0.7;
      world.seed = 3;
      const double scatter = scatter_of(variation);
      HeightFilter filter = filter_for(world, scatter);
      filter.set_substrate(HeightMap(world.grid, 0.0), world.everywhere(), noise);
      const auto n = Eigen::Index(world.grid.size());
      Dense dense{
          world.grid, world.model, scatter, noise, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
      for (int k = 1; k <= 12; ++k) {
        const Pass pass = world.print();
        const HeightMap map = world.measure();
        filter.add_layer({pass}, map, world.everywhere(), noise);
        dense.layer(pass.cells, map);
      }
      double off = 0.0, sum = 0.0;
      for (Eigen::Index c = 0; c < n; ++c) {
        const double ours = filter.surface().variance_mm2[std::size_t(c)];
        sum += ours;
        CHECK(ours > 0.8 * dense.p(c, c));
        CHECK(ours <
              2.2 *
                  dense.p(c, c));  // a cell walled in by its neighbours: their covariance with it is left out
        off += (filter.surface().height_mm[std::size_t(c)] - dense.x[c]) *
               (filter.surface().height_mm[std::size_t(c)] - dense.x[c]);
      }
      CHECK(sum == Approx(dense.p.trace()).epsilon(0.07));
      CHECK(std::sqrt(off / double(n)) < 0.4 * std::sqrt(dense.p.trace() / double(n)));
    }
}

TEST_CASE("The estimate errs less than the map and less than the droplets alone, and as much as it says") {
  for (const double variation : {0.2, 0.4}) {
    double of_filter = 0.0, of_map = 0.0, of_droplets = 0.0, said = 0.0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Planted world;
      world.variation = variation;
      world.seed = seed;
      world.fill = 0.85;
      HeightFilter filter = filter_for(world, scatter_of(variation)), blind = filter;
      filter.set_substrate(world.measure(), world.everywhere(), world.noise_mm);
      blind.set_substrate(HeightMap(world.grid, 0.0), world.everywhere(), world.noise_mm);
      HeightMap map;
      for (int k = 1; k <= 25; ++k) {
        const Pass pass = world.print();
        map = world.measure();
        filter.add_layer({pass}, map, world.everywhere(), world.noise_mm);
        blind.add_layer({pass}, map, std::vector<Use>(world.grid.size(), Use::kNothing), world.noise_mm);
      }
      of_filter += rms(filter.surface().height_mm, world.height.cells) / 4;
      of_map += rms(map.cells, world.height.cells) / 4;
      of_droplets += rms(blind.surface().height_mm, world.height.cells) / 4;
      said += filter.std_mm(Mask(world.grid, 1)) / 4;
    }
    INFO("variation " << variation << ": filter " << of_filter << ", map " << of_map << ", droplets "
                      << of_droplets);
    CHECK(of_filter < (variation < 0.3 ? 0.55 : 0.7) * of_map);
    CHECK(of_filter < 0.8 * of_droplets);
    CHECK(said == Approx(of_filter).epsilon(0.15));
  }
}

TEST_CASE(
    "A droplet that did not come is taken from the map at once, and a cell without a reading from the "
    "droplets") {
  Planted world;
  world.grid = {12, 12, 0.25, 0.25, 0.0, 0.0};
  world.height = HeightMap(world.grid, 0.0);
  world.noise_mm = 0.0002;
  world.fill = 1.0;
  HeightFilter filter = filter_for(world, scatter_of(world.variation));
  filter.set_substrate(world.measure(), world.everywhere(), world.noise_mm);
  for (int k = 0; k < 3; ++k) {
    const Pass pass = world.print();
    filter.add_layer({pass}, world.measure(), world.everywhere(), world.noise_mm);
  }
  const Pass pass = world.print();
  const std::size_t missed = world.grid.index(5, 5), unseen = world.grid.index(8, 3);
  HeightMap map = world.measure();
  map.cells[missed] -= world.model.h1_mm;
  map.cells[unseen] = kNotMeasured;
  auto use = world.everywhere();
  use[unseen] = Use::kNothing;
  filter.add_layer({pass}, map, use, world.noise_mm);
  CHECK(filter.surface().height_mm[missed] == map.cells[missed]);
  CHECK(filter.surface().height_mm[unseen] == Approx(world.height.cells[unseen]).margin(0.001));
  CHECK(filter.surface().variance_mm2[unseen] > 2.0 * filter.surface().variance_mm2[world.grid.index(3, 8)]);
}

TEST_CASE(
    "A second map of a layer takes the first one's place, bytes and all, and unknown droplets leave the map "
    "alone") {
  Planted world;
  HeightFilter twice = filter_for(world, 0.06), once = twice;
  const HeightMap ground = world.measure();
  twice.set_substrate(HeightMap(world.grid, 0.1), world.everywhere(), world.noise_mm);
  twice.replace_map(ground, world.everywhere(), world.noise_mm);
  once.set_substrate(ground, world.everywhere(), world.noise_mm);
  const Pass pass = world.print();
  const HeightMap map = world.measure();
  HeightMap lifted = map;
  for (double& z : lifted.cells) z += 0.0005;
  twice.add_layer({pass}, lifted, world.everywhere(), world.noise_mm);
  twice.replace_map(map, world.everywhere(), world.noise_mm);
  once.add_layer({pass}, map, world.everywhere(), world.noise_mm);
  CHECK(twice.surface().height_mm == once.surface().height_mm);
  CHECK(twice.surface().variance_mm2 == once.surface().variance_mm2);
  once.start_anew(lifted, world.everywhere(), world.noise_mm);
  CHECK(once.surface().height_mm == lifted.cells);
}

TEST_CASE("Bad layers are refused by name and leave the height filter as it was") {
  Planted world;
  HeightFilter filter = filter_for(world, 0.06);
  const HeightMap map = world.measure();
  CHECK_THROWS_WITH(filter.add_layer({}, map, world.everywhere(), 0.001),
                    Catch::Contains("before the map of the bare ground"));
  filter.set_substrate(map, world.everywhere(), world.noise_mm);
  const auto before = filter.surface().height_mm;
  CHECK_THROWS_WITH(filter.add_layer({}, map, world.everywhere(), 0.0), Catch::Contains("noise_std_mm"));
  CHECK_THROWS_WITH(filter.add_layer({Pass{{99999}, 1.0}}, map, world.everywhere(), 0.001),
                    Catch::Contains("off the grid"));
  CHECK_THROWS_WITH(filter.add_layer({Pass{{1}, 1.5}}, map, world.everywhere(), 0.001),
                    Catch::Contains("share"));
  CHECK_THROWS_WITH(filter.add_layer({}, HeightMap(GridSpec{2, 2}), {}, 0.001), Catch::Contains("size"));
  HeightMap hole = map;
  hole.cells[7] = kNotMeasured;
  CHECK_THROWS_WITH(filter.add_layer({}, hole, world.everywhere(), 0.001), Catch::Contains("cell 7"));
  CHECK_THROWS_WITH(filter.use_model(world.model, -0.1), Catch::Contains("droplet_scatter"));
  CHECK(filter.surface().height_mm == before);
}
