#include "estimators/droplet/droplet_estimator.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/estimators/planted.h"

using namespace firn;
using namespace firn::droplet;
using firn::test::Planted;

namespace {

deposition::DropletModel drawn(std::uint64_t seed) {
  const auto u = [&](std::uint32_t n) { return random_uniform({seed, Purpose::kTest, 0, 0, n}); };
  return {4.4e-3 * (0.8 + 0.4 * u(0)), 0.6e-3 * (0.7 + 0.6 * u(1)), 0.2e-3 * (0.6 + 0.8 * u(2))};
}

}  // namespace

TEST_CASE("The mean ramp is the mean of max(0, x + e) by summation, and its derivative the probability") {
  for (const double variance : {0.0, 1e-6, 4e-6}) {
    const double c = std::sqrt(7.0 * variance);
    for (double x = -0.008; x <= 0.008; x += 0.0007) {
      double sum = 0.0, above = 0.0, norm = 0.0;
      const int n = 4000;
      for (int k = 0; k < n; ++k) {
        const double u = (2.0 * k + 1.0) / n - 1.0, density = (1.0 - u * u) * (1.0 - u * u), e = c * u;
        norm += density;
        sum += density * std::max(0.0, x + e);
        above += density * (x + e > 0.0);
      }
      CHECK(mean_ramp(x, variance) == Approx(sum / norm).margin(1e-8));
      CHECK(step_probability(x, variance) == Approx(above / norm).margin(1e-3));
    }
  }
}

TEST_CASE("(5): on a surface that is known exactly a soft link is w sat(d)") {
  const double h1 = 4.4e-3, w = 0.6e-3;
  const SoftLink link{w, w / (h1 + w), h1 + w, 0.0};
  for (double d = -0.01; d < 0.01; d += 0.0003)
    CHECK(link.spread_mm(d, 0.0) == Approx(w * deposition::sat(h1 + w, d)).margin(1e-15));
}

TEST_CASE("What two droplets give, computed side by side, is to the bit what each gives alone") {
  RandomStream random(9, Purpose::kTest);
  const SoftLink links[2] = {{0.6e-3, 0.6 / 5.0, 5.0e-3, 4e-8}, {0.2e-3, 0.2 / 4.6, 4.6e-3, 0.0}};
  for (int trial = 0; trial < 20000; ++trial) {
    double d[2], v[2];
    for (int k = 0; k < 2; ++k) {
      d[k] = trial % 7 == 0 ? 0.0 : random.uniform(-0.01, 0.01);
      v[k] = random.below(4) == 0 ? 0.0 : 1e-6 * random.uniform(0.0, 4.0);
    }
    const SoftLink& link = links[trial % 2];
    const Two give = link.spread_mm(Two{d[0], d[1]}, Two{v[0], v[1]}),
              k = link.sensitivity(Two{d[0], d[1]}, Two{v[0], v[1]});
    for (int n = 0; n < 2; ++n) {
      REQUIRE(give[n] == link.spread_mm(d[n], v[n]));
      REQUIRE(k[n] == link.sensitivity(d[n], v[n]));
    }
  }
}

TEST_CASE("3 x 3 inverse, determinant, sandwich and least eigenvalue agree with Eigen") {
  RandomStream random(5, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    Eigen::Matrix3d x;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) x(r, c) = random.uniform(-1.0, 1.0);
    const Eigen::Matrix3d a = x * x.transpose() + 0.01 * Eigen::Matrix3d::Identity(), b = x.transpose() * x;
    Symmetric3 sa, sb;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        sa.at(r, c) = a(r, c);
        sb.at(r, c) = b(r, c);
      }
    const Symmetric3 i = inverse(sa), s = sandwich(sa, sb);
    const Eigen::Matrix3d ei = a.inverse(), es = a * b * a;
    const Eigen::Matrix3d scaled = a.diagonal().cwiseSqrt().cwiseInverse().asDiagonal() * a *
                                   a.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
    CHECK(determinant(sa) == Approx(a.determinant()));
    CHECK(separation(sa) ==
          Approx(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scaled).eigenvalues()(0)).margin(1e-12));
    CHECK(positive_definite(sa));
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        CHECK(i.at(r, c) == Approx(ei(r, c)).epsilon(1e-6));
        CHECK(s.at(r, c) == Approx(es(r, c)).margin(1e-12));
      }
  }
}

TEST_CASE("Without noise and scatter the planted h1, h2, h3 come back") {
  Planted p;
  p.grid = {20, 18, 0.25, 0.25, 0.0, 0.0};
  p.height = HeightMap(p.grid, 0.0);
  p.model = drawn(3);
  p.variation = 0.0;
  p.noise_mm = 1e-6;
  DropletEstimator estimator(p.grid, p.options());
  const Estimate e = p.learn(estimator, 4);
  CHECK(e.model.h1_mm == Approx(p.model.h1_mm).epsilon(2e-4));
  CHECK(e.model.h2_mm == Approx(p.model.h2_mm).epsilon(2e-4));
  CHECK(e.model.h3_mm == Approx(p.model.h3_mm).epsilon(5e-4));
  CHECK(e.layers == 4);
  CHECK(e.excitation > 0.03);
}

TEST_CASE("Layers that are kept until the next estimate count as those that are estimated one by one") {
  for (const int window : {3, 10}) {
    INFO("window " << window);
    Planted one, many;
    one.seed = many.seed = 5;
    one.model = many.model = drawn(5);
    EstimatorOptions options = one.options();
    options.window_layers = window;
    DropletEstimator each(one.grid, options), rarely(many.grid, options);
    Estimate a, b;
    std::int64_t evaluations_each = 0, evaluations_rarely = 0;
    rarely.set_substrate(many.measure(), many.everywhere(), many.noise_mm);
    for (int k = 1; k <= 24; ++k) {
      a = one.learn(each, 1);
      evaluations_each += a.evaluations;
      if (k % 8 != 0) {
        Pass pass = many.print();
        rarely.keep_layer({std::move(pass)}, many.measure(), many.everywhere(), many.noise_mm);
        continue;
      }
      b = many.learn(rarely, 1);
      evaluations_rarely += b.evaluations;
    }
    CHECK(b.layers == a.layers);
    CHECK(b.droplets == a.droplets);
    for (int n = 0; n < 3; ++n) {
      INFO("h" << n + 1);
      const std::array<double, 3> of_a{a.model.h1_mm, a.model.h2_mm, a.model.h3_mm},
          of_b{b.model.h1_mm, b.model.h2_mm, b.model.h3_mm};
      CHECK(std::abs(of_a[std::size_t(n)] - of_b[std::size_t(n)]) < 0.3 * a.std_mm(n));
      CHECK(b.std_mm(n) == Approx(a.std_mm(n)).epsilon(0.1));
    }
    CHECK(3 * evaluations_rarely < evaluations_each);
  }
}

TEST_CASE("The estimates of a record cost as much for its last layers as for its first") {
  Planted p;
  p.grid = {12, 12, 0.263256, 0.263256, 0.0, 0.0};
  p.height = HeightMap(p.grid, 0.0);
  DropletEstimator estimator(p.grid, p.options());
  const auto evaluations = [&](int layers) {
    std::int64_t sum = 0;
    for (int n = 0; n < layers; ++n) sum += p.learn(estimator, 1).evaluations;
    return double(sum);
  };
  const double first = evaluations(20), next = evaluations(20), after = evaluations(40);
  CHECK(next < 1.1 * first);
  CHECK(after < 1.1 * (first + next));
}

TEST_CASE("After 10 half-filled layers at 1 um per cell: within 3 %, within 3 sigma, intervals that cover") {
  int covered[4] = {};
  const int seeds = 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Planted p;
    p.seed = seed;
    p.model = drawn(seed);
    DropletEstimator estimator(p.grid, p.options());
    const Estimate e = p.learn(estimator, 10);
    const double truth[] = {p.model.h1_mm, p.model.h2_mm, p.model.h3_mm, p.model.layer_height_mm()};
    const double ours[] = {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm, e.model.layer_height_mm()};
    const double sigma[] = {e.std_mm(0), e.std_mm(1), e.std_mm(2), e.layer_height_std_mm()};
    INFO("seed " << seed);
    CHECK(std::abs(ours[0] / truth[0] - 1.0) < 0.03);
    CHECK(std::abs(ours[3] / truth[3] - 1.0) < 0.03);
    for (int n = 0; n < 4; ++n) {
      CHECK(std::abs(ours[n] - truth[n]) < 3.5 * sigma[n]);  // 80 draws: one beyond 3 is no surprise
      covered[n] += std::abs(ours[n] - truth[n]) < 1.96 * sigma[n];
    }
  }
  for (int n = 0; n < 4; ++n) CHECK(covered[n] >= 16);  // 19 expected; 15 or fewer by chance: 3 in 1000
}

TEST_CASE("Taking sat() at the measured difference is wrong by many sigma where the filtered mean is right") {
  // The textbook regression: dH = map - map before, sat at the map before, least squares in h1, h2, h3.
  double naive_h2 = 0.0, ours_h2 = 0.0, sigma = 0.0;
  Planted p;
  p.model = {};
  DropletEstimator estimator(p.grid, p.options());
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  HeightMap before = p.measure();
  estimator.set_substrate(before, p.everywhere(), p.noise_mm);
  for (int k = 0; k < 10; ++k) {
    const Pass pass = p.print();
    const HeightMap after = p.measure();
    DropletPattern drops(p.grid);
    for (const auto c : pass.cells) drops.cells[c] = 1;
    std::array<HeightMap, 3> column;
    for (int n = 0; n < 3; ++n) {  // dH is linear in (h1, h2, h3) when sat's own thresholds are held
      deposition::DropletModel at = p.model;
      (n == 0 ? at.h1_mm : n == 1 ? at.h2_mm : at.h3_mm) *= 1.001;
      HeightMap up = before, base = before;
      deposition::HeightChange<1>(p.grid, deposition::stencil_of(at), deposition::Border::kLose)
          .deposit(up, drops);
      deposition::HeightChange<1>(p.grid, deposition::stencil_of(p.model), deposition::Border::kLose)
          .deposit(base, drops);
      column[std::size_t(n)] = HeightMap(p.grid);
      const double step = 0.001 * (n == 0 ? p.model.h1_mm : n == 1 ? p.model.h2_mm : p.model.h3_mm);
      for (std::size_t c = 0; c < up.size(); ++c)
        column[std::size_t(n)].cells[c] = (up.cells[c] - base.cells[c]) / step;
    }
    for (std::size_t c = 0; c < after.size(); ++c) {
      const Eigen::Vector3d g(column[0].cells[c], column[1].cells[c], column[2].cells[c]);
      normal += g * g.transpose();
      right += g * (after.cells[c] - before.cells[c]);
    }
    estimator.add_layer({pass}, after, p.everywhere(), p.noise_mm);
    before = after;
  }
  naive_h2 = (normal.inverse() * right)(1);
  ours_h2 = estimator.estimate().model.h2_mm;
  sigma = estimator.estimate().std_mm(1);
  CHECK(std::abs(naive_h2 - p.model.h2_mm) > 10.0 * sigma);
  CHECK(std::abs(ours_h2 - p.model.h2_mm) < 3.0 * sigma);
}

TEST_CASE("Full layers tell h1 + 4 h2 + 4 h3 and hardly anything else, and the estimate says so") {
  Planted p;
  p.fill = 1.1;
  p.model = {4.8e-3, 0.5e-3, 0.25e-3};
  DropletEstimator estimator(p.grid, p.options());
  const Estimate full = p.learn(estimator, 4);
  Planted q;
  q.model = p.model;
  DropletEstimator other(q.grid, q.options());
  const Estimate half = q.learn(other, 4);
  CHECK(full.excitation < 0.2 * half.excitation);
  CHECK(full.std_mm(0) > 5.0 * half.std_mm(0));
  CHECK(full.layer_height_std_mm() < 0.01 * p.model.layer_height_mm());
  CHECK(std::abs(full.model.layer_height_mm() - p.model.layer_height_mm()) <
        3.0 * full.layer_height_std_mm());
  CHECK(std::abs(full.model.h1_mm - p.model.h1_mm) < 3.0 * full.std_mm(0));
}

TEST_CASE("Layers behind the window still count, and what was learned does not get lost") {
  Planted p;
  p.model = drawn(8);
  EstimatorOptions o = p.options();
  o.window_layers = 4;
  DropletEstimator estimator(p.grid, o);
  const Estimate early = p.learn(estimator, 4), late = p.learn(estimator, 12);
  CHECK(late.layers == 16);
  CHECK(late.std_mm(0) < 0.8 * early.std_mm(0));
  CHECK(late.layer_height_std_mm() < 0.8 * early.layer_height_std_mm());
  CHECK(std::abs(late.model.h1_mm - p.model.h1_mm) < 3.0 * late.std_mm(0));
  CHECK(std::abs(late.model.layer_height_mm() - p.model.layer_height_mm()) <
        3.0 * late.layer_height_std_mm());
}

TEST_CASE("Missed droplets, cells without a reading and a pass in doubt do not spoil the estimate") {
  Planted p;
  p.model = drawn(9);
  DropletEstimator estimator(p.grid, p.options());
  estimator.set_substrate(p.measure(), p.everywhere(), p.noise_mm);
  for (int k = 1; k <= 10; ++k) {
    Pass pass = p.print();
    std::vector<Use> use = p.everywhere();
    HeightMap y = p.measure();
    for (std::uint32_t c = 0; c < y.size(); ++c)
      if (random_uniform({1, Purpose::kDropout, std::uint32_t(k), 0, c}) < 0.05) {
        y.cells[c] = std::numeric_limits<double>::quiet_NaN();
        use[c] = Use::kNothing;
      }
    if (k == 5) {  // half of the pass is in doubt: not said to have fired, its cells only measured
      for (const auto c : pass.cells)
        if (c < p.grid.size() / 2)
          for (int n = -1; n <= 1; ++n)
            for (int m = -1; m <= 1; ++m) {
              const std::int64_t at = std::int64_t(c) + m * p.grid.nx + n;
              if (at >= 0 && at < std::int64_t(y.size()) && use[std::size_t(at)] == Use::kLearn)
                use[std::size_t(at)] = Use::kAnchor;
            }
      std::erase_if(pass.cells, [&](std::uint32_t c) { return c < p.grid.size() / 2; });
    }
    // Three droplets per layer that were counted but are not there: reported as fired, landed nowhere.
    for (std::uint32_t n = 0; n < 3; ++n)
      pass.cells.push_back(random_below({2, Purpose::kMissedDroplet, std::uint32_t(k), 0, n}, 1600));
    std::sort(pass.cells.begin(), pass.cells.end());
    pass.cells.erase(std::unique(pass.cells.begin(), pass.cells.end()), pass.cells.end());
    estimator.add_layer({pass}, y, use, p.noise_mm);
  }
  const Estimate& e = estimator.estimate();
  CHECK(e.model.h1_mm == Approx(p.model.h1_mm).epsilon(0.03));
  CHECK(e.model.layer_height_mm() == Approx(p.model.layer_height_mm()).epsilon(0.03));
}

TEST_CASE("The same layers give the same bytes, and a map that is measured again replaces the first") {
  Planted p;
  p.model = drawn(4);
  DropletEstimator a(p.grid, p.options()), b(p.grid, p.options());
  a.set_substrate(p.measure(), p.everywhere(), p.noise_mm);
  b.set_substrate(HeightMap(p.grid, 0.5), p.everywhere(), p.noise_mm);
  b.replace_map(p.measure(), p.everywhere(), p.noise_mm);
  for (int k = 0; k < 3; ++k) {
    const Pass pass = p.print();
    a.add_layer({pass}, p.measure(), p.everywhere(), p.noise_mm);
    b.add_layer({pass}, p.measure(), p.everywhere(), p.noise_mm);
  }
  CHECK(a.estimate().model == b.estimate().model);
  CHECK(a.estimate().covariance_mm2.m == b.estimate().covariance_mm2.m);
  HeightMap wrong = p.measure();
  for (double& z : wrong.cells) z += 0.003;
  const Pass pass = p.print();
  a.add_layer({pass}, p.measure(), p.everywhere(), p.noise_mm);
  b.add_layer({pass}, wrong, p.everywhere(), p.noise_mm);
  b.replace_map(p.measure(), p.everywhere(), p.noise_mm);
  CHECK(b.estimate().model.h1_mm == Approx(a.estimate().model.h1_mm).epsilon(2e-3));
  CHECK(b.estimate().layers == 4);
}

TEST_CASE("Wrong options and maps are named") {
  const GridSpec g{4, 4, 0.25, 0.25, 0.0, 0.0};
  EstimatorOptions o;
  o.prior_std = 0.0;
  CHECK_THROWS_WITH(DropletEstimator(g, o), Catch::Contains("prior_std"));
  o.prior_std = 0.5;
  o.window_layers = 0;
  CHECK_THROWS_WITH(DropletEstimator(g, o), Catch::Contains("window_layers"));
  DropletEstimator e(g, {});
  const std::vector<Use> use(16, Use::kLearn);
  CHECK_THROWS_WITH(e.add_layer({}, HeightMap(g, 0.0), use, 0.001), Catch::Contains("bare ground"));
  CHECK_THROWS_WITH(e.set_substrate(HeightMap(g, 0.0), use, 0.0), Catch::Contains("noise"));
  CHECK_THROWS_WITH(e.set_substrate(HeightMap(g, std::numeric_limits<double>::quiet_NaN()), use, 0.001),
                    Catch::Contains("cell 0"));
  e.set_substrate(HeightMap(g, 0.0), use, 0.001);
  CHECK_THROWS_WITH(e.add_layer({{{99}, 1.0}}, HeightMap(g, 0.0), use, 0.001),
                    Catch::Contains("off the grid"));
}

TEST_CASE("A layer height that a camera saw is weighted against the prior by the two variances") {
  EstimatorOptions options;
  options.prior = {4.4e-3, 0.6e-3, 0.2e-3};
  const GridSpec grid{12, 12, 0.25, 0.25, 0.0, 0.0};
  DropletEstimator estimator(grid, options);
  const double prior_mm = options.prior.layer_height_mm(),
               prior_std_mm = estimator.estimate().layer_height_std_mm();
  const double seen_mm = 0.8 * prior_mm, std_mm = 0.5 * prior_std_mm;
  estimator.believe_height(2.0 * seen_mm, std_mm);  // the next one takes its place
  estimator.believe_height(seen_mm, std_mm);
  const double a = 1.0 / (prior_std_mm * prior_std_mm), b = 1.0 / (std_mm * std_mm);
  CHECK(estimator.estimate().model.layer_height_mm() == Approx((a * prior_mm + b * seen_mm) / (a + b)));
  CHECK(estimator.estimate().layer_height_std_mm() == Approx(1.0 / std::sqrt(a + b)));
}

TEST_CASE("Beside maps a seen layer height counts by its variance") {
  const auto height_after = [](double seen_share, double std_share) {
    Planted world;
    world.grid = {12, 12, 0.25, 0.25, 0.0, 0.0};
    world.height = HeightMap(world.grid, 0.0);
    world.model = {4.4e-3, 0.6e-3, 0.2e-3};
    world.noise_mm = 0.0005;
    EstimatorOptions options;
    options.prior = world.model;
    DropletEstimator estimator(world.grid, options);
    const std::vector<Use> use(world.grid.size(), Use::kLearn);
    estimator.set_substrate(world.measure(), use, world.noise_mm);
    const double planted_mm = world.model.layer_height_mm();
    if (std_share > 0.0) estimator.believe_height(seen_share * planted_mm, std_share * planted_mm);
    for (int n = 0; n < 3; ++n) {
      Pass pass = world.print();
      estimator.add_layer({pass}, world.measure(), use, world.noise_mm);
    }
    return estimator.estimate().model.layer_height_mm() / planted_mm;
  };
  const double without = height_after(1.0, 0.0);
  CHECK(height_after(1.3, 100.0) == Approx(without).margin(1e-4));
  CHECK(height_after(1.3, 1e-4) == Approx(1.3).margin(0.02));
  const double between = height_after(1.3, 0.01);
  CHECK(between > without + 0.01);
  CHECK(between < 1.29);
}

TEST_CASE("With a memory the estimate follows a jet that drifts, and without one it lags behind") {
  for (const std::uint64_t seed : {1, 2}) {
    Planted world;
    world.grid = {24, 24, 0.25, 0.25, 0.0, 0.0};
    world.height = HeightMap(world.grid, 0.0);
    world.seed = seed;
    EstimatorOptions options = world.options();
    options.window_layers = 3;
    DropletEstimator all(world.grid, options);
    options.memory_layers = 6.0;
    DropletEstimator fading(world.grid, options);
    for (DropletEstimator* e : {&all, &fading})
      e->set_substrate(world.measure(), world.everywhere(), world.noise_mm);
    const deposition::DropletModel first = world.model;
    for (int k = 0; k < 30; ++k) {  // a third less in thirty layers
      const double s = 1.0 - 0.011 * k;
      world.model = {s * first.h1_mm, s * first.h2_mm, s * first.h3_mm};
      const Pass pass = world.print();
      for (DropletEstimator* e : {&all, &fading})
        e->add_layer({pass}, world.measure(), world.everywhere(), world.noise_mm);
    }
    const auto off = [&](const DropletEstimator& e) {
      return e.estimate().model.h1_mm / world.model.h1_mm - 1.0;
    };
    INFO("off by " << off(all) << " without and " << off(fading) << " with a memory");
    CHECK(off(all) > 0.10);
    CHECK(std::abs(off(fading)) < 0.09);  // five layers' lag
    CHECK(std::abs(fading.estimate().model.layer_height_mm() / world.model.layer_height_mm() - 1.0) < 0.09);
  }
}

TEST_CASE("A memory without end is none: estimates of the two agree") {
  Planted world;
  world.grid = {16, 16, 0.25, 0.25, 0.0, 0.0};
  world.height = HeightMap(world.grid, 0.0);
  Planted again = world;
  EstimatorOptions options = world.options();
  options.window_layers = 2;
  DropletEstimator all(world.grid, options);
  options.memory_layers = 1e6;
  DropletEstimator long_memory(world.grid, options);
  const Estimate a = world.learn(all, 6), b = again.learn(long_memory, 6);
  CHECK(b.model.h1_mm == Approx(a.model.h1_mm).epsilon(1e-4));
  CHECK(b.std_mm(0) == Approx(a.std_mm(0)).epsilon(1e-3));
  options.memory_layers = 1.5;
  CHECK_THROWS_WITH(DropletEstimator(world.grid, options), Catch::Contains("memory_layers"));
}
