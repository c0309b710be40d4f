#include "estimators/surface/robust_smoothing.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "estimators/surface/cosine_transform.h"

using namespace firn;
using namespace firn::surface;

namespace {

double worst(const std::vector<double>& a, const std::vector<double>& b) {
  double w = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) w = std::max(w, std::abs(a[n] - b[n]));
  return w;
}

HeightMap random_map(const GridSpec& g, RandomStream& random) {
  HeightMap h(g);
  for (double& v : h.cells) v = random.uniform(0.0, 0.02);
  return h;
}

// The normal equations (diag(W) + s D'D) z = W y, D by mirrored second differences, solved densely.
std::vector<double> dense_solution(const HeightMap& y, const std::vector<double>& weight, double s) {
  const GridSpec& g = y.spec;
  const int n = int(g.size());
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n, n);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const int c = int(g.index(i, j));
      for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (g.contains(i + di, j + dj)) {
          d(c, int(g.index(i + di, j + dj))) += 1.0;
          d(c, c) -= 1.0;
        }
    }
  Eigen::MatrixXd a = s * d.transpose() * d;
  Eigen::VectorXd b(n);
  for (int c = 0; c < n; ++c) {
    a(c, c) += weight[std::size_t(c)];
    b[c] = weight[std::size_t(c)] > 0.0 ? weight[std::size_t(c)] * y.cells[std::size_t(c)] : 0.0;
  }
  const Eigen::VectorXd z = a.ldlt().solve(b);
  return {z.data(), z.data() + n};
}

double bump(double x, double y) { return 0.02 * std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / 8.0); }

}  // namespace

TEST_CASE("cos_pi is the cosine to the last bits") {
  for (long n : {1L, 2L, 3L, 7L, 40L, 80L, 1001L})
    for (long k = -3 * n; k <= 5 * n; ++k)
      CHECK(std::abs(cos_pi(k, n) - std::cos(std::acos(-1.0) * double(k % (2 * n)) / double(n))) < 2e-15);
  CHECK(cos_pi(1, 2) == 0.0);
  CHECK(cos_pi(1, 1) == -1.0);
}

TEST_CASE("The transform is the orthonormal DCT-II of every size, and inverse undoes forward") {
  RandomStream random(1, Purpose::kTest);
  const double pi = std::acos(-1.0);
  for (const auto& [nx, ny] :
       {std::pair{1, 1}, {2, 2}, {4, 6}, {5, 4}, {4, 5}, {7, 3}, {1, 8}, {16, 1}, {9, 9}}) {
    std::vector<double> in(std::size_t(nx * ny)), out(in.size()), back(in.size()), direct(in.size());
    for (double& v : in) v = random.uniform(-1.0, 1.0);
    for (int q = 0; q < ny; ++q)
      for (int p = 0; p < nx; ++p) {
        double sum = 0.0;
        for (int j = 0; j < ny; ++j)
          for (int i = 0; i < nx; ++i)
            sum += in[std::size_t(j * nx + i)] * std::cos(pi * p * (2 * i + 1) / (2.0 * nx)) *
                   std::cos(pi * q * (2 * j + 1) / (2.0 * ny));
        direct[std::size_t(q * nx + p)] =
            sum * std::sqrt((p ? 2.0 : 1.0) / nx) * std::sqrt((q ? 2.0 : 1.0) / ny);
      }
    CosineTransform dct(nx, ny);
    dct.forward(in, out);
    CHECK(worst(out, direct) < 1e-13);
    dct.inverse(out, back);
    CHECK(worst(back, in) < 1e-13);
  }
}

TEST_CASE("With full data and given s the smoother is the dense solution, odd and even sizes") {
  RandomStream random(2, Purpose::kTest);
  for (const GridSpec g :
       {GridSpec{8, 6}, GridSpec{7, 6}, GridSpec{6, 7}, GridSpec{9, 5}, GridSpec{1, 12}, GridSpec{11, 1}})
    for (const double s : {0.01, 1.0, 50.0}) {
      const HeightMap y = random_map(g, random);
      const Smoothed z = RobustSmoother(g).smooth(y, nullptr, {s, false});
      CHECK(worst(z.height.cells, dense_solution(y, std::vector<double>(g.size(), 1.0), s)) < 1e-12);
      CHECK(z.s == s);
      CHECK(z.iterations == 1);
    }
}

TEST_CASE("With missing values and weights it converges to the dense weighted solution") {
  RandomStream random(3, Purpose::kTest);
  for (const GridSpec g : {GridSpec{8, 8}, GridSpec{9, 7}}) {
    HeightMap y = random_map(g, random);
    Grid<double> weights(g, 1.0);
    for (std::size_t c = 0; c < g.size(); ++c) {
      if (random.below(6) == 0) y.cells[c] = kNotMeasured;
      if (random.below(4) == 0) weights.cells[c] = random.uniform(0.3, 1.0);
    }
    std::vector<double> effective = weights.cells;
    for (std::size_t c = 0; c < g.size(); ++c)
      if (!std::isfinite(y.cells[c])) effective[c] = 0.0;
    SmoothingOptions o{0.5, false};
    o.max_iterations = 4000;
    o.tolerance = 1e-13;
    const Smoothed z = RobustSmoother(g).smooth(y, &weights, o);
    CHECK(worst(z.height.cells, dense_solution(y, effective, 0.5)) < 1e-9);
    for (std::size_t c = 0; c < g.size(); ++c)
      if (!std::isfinite(y.cells[c])) CHECK(z.weights.cells[c] == 0.0);
  }
}

TEST_CASE("GCV: the chosen s is the candidate of least score, and the noise is found") {
  const GridSpec g{40, 40};
  for (const double noise : {0.0005, 0.001, 0.003}) {
    RandomStream random(4, Purpose::kTest);
    HeightMap truth(g), y(g);
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        truth.at(i, j) = 0.3 + bump(i * 0.25, j * 0.25);
        y.at(i, j) = truth.at(i, j) + noise * random.normal();
      }
    RobustSmoother smoother(g);
    const Smoothed z = smoother.smooth(y, nullptr, {});
    CHECK(z.noise_std_mm == Approx(noise).epsilon(0.1));
    double error = 0.0;
    for (std::size_t c = 0; c < g.size(); ++c)
      error += (z.height.cells[c] - truth.cells[c]) * (z.height.cells[c] - truth.cells[c]);
    CHECK(std::sqrt(error / 1600.0) < 0.3 * noise);
    // The score of GCV by its definition, for a single fit of full data: no candidate within two decades is
    // lower.
    const auto score = [&](double s) {
      const Smoothed fit = smoother.smooth(y, nullptr, {s, false});
      double rss = 0.0, trace = 0.0;
      for (std::size_t c = 0; c < g.size(); ++c)
        rss += (y.cells[c] - fit.height.cells[c]) * (y.cells[c] - fit.height.cells[c]);
      for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i) {
          const double l = 2 * (cos_pi(i, 40) - 1) + 2 * (cos_pi(j, 40) - 1);
          trace += 1.0 / (1.0 + s * l * l);
        }
      return rss / 1600.0 / ((1.0 - trace / 1600.0) * (1.0 - trace / 1600.0));
    };
    SmoothingOptions plain;
    plain.robust = false;
    const double s = smoother.smooth(y, nullptr, plain).s, best = score(s);
    for (double f = 0.01; f < 101.0; f *= 1.5) CHECK(best <= score(s * f) * (1.0 + 1e-6));
  }
}

TEST_CASE("Outliers get no weight and leave the surface alone, and missing patches are bridged") {
  const GridSpec g{40, 40};
  RandomStream random(5, Purpose::kTest);
  HeightMap truth(g), y(g);
  Grid<std::uint8_t> bad(g);
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 40; ++i) {
      truth.at(i, j) = bump(i * 0.25, j * 0.25);
      y.at(i, j) = truth.at(i, j) + 0.001 * random.normal();
      if (random.below(25) == 0) {
        bad.at(i, j) = 1;
        y.at(i, j) += random.below(2) ? 0.05 : -0.05;
      }
      if (i >= 10 && i < 14 && j >= 20 && j < 25) y.at(i, j) = kNotMeasured;
    }
  RobustSmoother smoother(g);
  const Smoothed z = smoother.smooth(y, nullptr, {});
  SmoothingOptions plain;
  plain.robust = false;
  const Smoothed fragile = smoother.smooth(y, nullptr, plain);
  double robust_worst = 0.0, fragile_worst = 0.0;
  for (std::size_t c = 0; c < g.size(); ++c) {
    REQUIRE(std::isfinite(z.height.cells[c]));
    robust_worst = std::max(robust_worst, std::abs(z.height.cells[c] - truth.cells[c]));
    fragile_worst = std::max(fragile_worst, std::abs(fragile.height.cells[c] - truth.cells[c]));
    if (bad.cells[c]) CHECK(z.weights.cells[c] < 0.01);
  }
  CHECK(robust_worst < 0.002);
  CHECK(fragile_worst > 2.0 * robust_worst);
  CHECK(z.noise_std_mm == Approx(0.001).epsilon(0.15));
}

TEST_CASE("A constant map, a single row, all missing and two known cells are answered sensibly") {
  RobustSmoother smoother(GridSpec{6, 5});
  const Smoothed flat = smoother.smooth(HeightMap(GridSpec{6, 5}, 0.3), nullptr, {});
  for (double v : flat.height.cells) CHECK(v == Approx(0.3).margin(1e-12));
  CHECK(flat.noise_std_mm < 1e-12);
  HeightMap few(GridSpec{6, 5}, kNotMeasured);
  for (double v : smoother.smooth(few, nullptr, {}).height.cells) CHECK(v == 0.0);
  few.at(1, 1) = 0.1;
  few.at(4, 4) = 0.3;
  for (double v : smoother.smooth(few, nullptr, {}).height.cells) CHECK(v == Approx(0.2));
}

TEST_CASE("Equal maps give equal bytes, and wrong input is refused") {
  const GridSpec g{40, 40};
  RandomStream random(6, Purpose::kTest);
  const HeightMap y = random_map(g, random);
  RobustSmoother a(g), b(g);
  b.smooth(random_map(g, random), nullptr, {});
  CHECK(a.smooth(y, nullptr, {}).height == b.smooth(y, nullptr, {}).height);
  CHECK_THROWS_WITH(a.smooth(HeightMap(GridSpec{3, 3}), nullptr, {}), Catch::Contains("1600 cells"));
  Grid<double> heavy(g, 1.5);
  CHECK_THROWS_WITH(a.smooth(y, &heavy, {}), Catch::Contains("outside 0..1"));
  CHECK_THROWS_WITH(a.smooth(y, nullptr, {-1.0}), Catch::Contains("s = -1"));
}
