#include "core/control/smf_line/smf_line.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"
#include "tests/support/long_cases.h"

using namespace firn;
using namespace firn::control::smf_line;

namespace {

Gains some_gains(RandomStream& random) {
  return {-0.5 + 3.0 * random.uniform(), -0.5 + 5.0 * random.uniform(), -1.3 + 2.6 * random.uniform()};
}

std::vector<double> run(const Gains& g, const std::vector<double>& d) {
  std::vector<double> e(d.size());
  simulate(g, d, e);
  return e;
}

// Growth of the free loop (5.20) from three independent states at once: the largest state of the last fifth
// against that of the second fifth, after 5,000 steps, or ten and a hundred times as many where that is not
// decided by a factor of e^6 (a growing part may start small beside one that dies out slowly). Fifty steps
// are taken one by one, more of them by what those make of each state. No pole is computed.
bool dies_out(const Gains& g) {
  constexpr int kBlock = 50;
  const double c1 = -g.kd_star, c2 = g.kp + 2.0 * g.kd_star - 1.0, c3 = 2.0 - g.kp - g.ki_star - g.kd_star;
  double block[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // oldest, middle and newest error of each state
  for (double* e : block)
    for (int k = 0; k < kBlock; ++k) {
      const double next = c1 * e[0] + c2 * e[1] + c3 * e[2];
      e[0] = e[1];
      e[1] = e[2];
      e[2] = next;
    }
  double state[3][3];
  std::copy(&block[0][0], &block[0][0] + 9, &state[0][0]);
  double scale_log = 0.0, second = 0.0, last = 0.0;
  int k = kBlock;
  for (const int steps : {5'000, 50'000, 500'000}) {
    second = last = -1e300;
    const int from = k, fifth = (steps - from) / 5;
    for (; k < steps; k += kBlock) {
      double largest = 0.0;
      for (const double* e : state)
        for (int n = 0; n < 3; ++n) largest = std::max(largest, std::abs(e[n]));
      if (largest == 0.0) return true;
      const double size = scale_log + std::log(largest);
      if (k >= from + fifth && k < from + 2 * fifth) second = std::max(second, size);
      if (k >= steps - fifth) last = std::max(last, size);
      double scale = 1.0;
      if (largest > 1e100 || largest < 1e-100) {
        scale = 1.0 / largest;
        scale_log += std::log(largest);
      }
      for (double* e : state) {
        const double x = scale * e[0], y = scale * e[1], z = scale * e[2];
        for (int n = 0; n < 3; ++n) e[n] = x * block[0][n] + y * block[1][n] + z * block[2][n];
      }
    }
    if (std::abs(last - second) > 6.0) break;
  }
  return last < second;
}

double largest_eigenvalue(const Gains& g) {
  Eigen::Matrix3d a;
  a << 0, 1, 0, 0, 0, 1, -g.kd_star, g.kp + 2 * g.kd_star - 1, 2 - g.kp - g.ki_star - g.kd_star;
  return a.eigenvalues().cwiseAbs().maxCoeff();
}

// Gains at `distance` (in gain space, either side) from a point of the boundary, found by bisection along a
// random ray from inside the stable set.
Gains near_boundary(RandomStream& random, double distance) {
  const Gains inside{0.3 + 0.9 * random.uniform(), 0.05 + 0.4 * random.uniform(), 0.15 * random.uniform()};
  const double a = random.uniform() - 0.5, b = random.uniform() - 0.5, c = random.uniform() - 0.5;
  const double norm = std::sqrt(a * a + b * b + c * c) + 1e-12;
  const auto at = [&](double t) {
    return Gains{inside.kp + t * a / norm, inside.ki_star + t * b / norm, inside.kd_star + t * c / norm};
  };
  double low = 0.0, high = 10.0;
  for (int n = 0; n < 80; ++n) {
    const double middle = 0.5 * (low + high);
    (stable(at(middle)) ? low : high) = middle;
  }
  return at(low + distance);
}

}  // namespace

TEST_CASE("(5.11), errata: e_1 = 0, no derivative at k = 1, and e_{k+1} = e_k - u_k - d_k, by hand") {
  const std::vector<double> d{0.5, 0.0, -0.25, 0.0};
  std::vector<double> e(4), u(4);
  simulate({0.5, 0.25, 0.125}, d, e, u);
  CHECK(e[0] == 0.0);
  CHECK(u[0] == 0.0);
  CHECK(e[1] == -0.5);
  CHECK(u[1] == 0.5 * -0.5 + 0.25 * -0.5 + 0.125 * -0.5);
  CHECK(e[2] == e[1] - u[1]);
  CHECK(u[2] == Approx(0.5 * e[2] + 0.25 * (e[1] + e[2]) + 0.125 * (e[2] - e[1])));
  CHECK(e[3] == Approx(e[2] - u[2] + 0.25));
}

TEST_CASE("(5.19): the errors satisfy the difference equation driven by d_{k+1} - d_{k+2}") {
  RandomStream random(11, Purpose::kTest);
  for (int trial = 0; trial < 50; ++trial) {
    const Gains g{random.uniform(), 0.5 * random.uniform(), 0.3 * random.uniform()};
    std::vector<double> d(40);
    for (double& v : d) v = random.uniform() - 0.5;
    const auto e = run(g, d);
    for (std::size_t k = 0; k + 3 < e.size(); ++k) {
      const double left = e[k + 3] + (g.kp + g.ki_star + g.kd_star - 2) * e[k + 2] +
                          (1 - g.kp - 2 * g.kd_star) * e[k + 1] + g.kd_star * e[k];
      // The derivative left out at k = 1 shows in the first equation: e_0 does not exist.
      CHECK(left == Approx(d[k + 1] - d[k + 2]).margin(1e-12));
    }
  }
}

TEST_CASE("(5.34), (5.35) as corrected: the gradient is that of central differences") {
  RandomStream random(12, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    const Gains g{1.4 * random.uniform(), 0.8 * random.uniform(), 0.25 * random.uniform()};
    std::vector<double> d(60);
    for (double& v : d) v = random.uniform() - 0.5;
    const Spread s = spread(g, d);
    const double h = 1e-6;
    const auto rms = [&](double p, double i, double dd) {
      return spread({g.kp + p, g.ki_star + i, g.kd_star + dd}, d).rms;
    };
    const double scale = 1.0 + s.rms;
    CHECK(s.gradient[0] ==
          Approx((rms(h, 0, 0) - rms(-h, 0, 0)) / (2 * h)).epsilon(1e-4).margin(1e-5 * scale));
    CHECK(s.gradient[1] ==
          Approx((rms(0, h, 0) - rms(0, -h, 0)) / (2 * h)).epsilon(1e-4).margin(1e-5 * scale));
    CHECK(s.gradient[2] ==
          Approx((rms(0, 0, h) - rms(0, 0, -h)) / (2 * h)).epsilon(1e-4).margin(1e-5 * scale));
  }
}

TEST_CASE("(5.22): the poles are the eigenvalues of the matrix of (5.20)") {
  RandomStream random(13, Purpose::kTest);
  for (int trial = 0; trial < 2000; ++trial) {
    const Gains g = some_gains(random);
    CHECK(largest_pole(g) == Approx(largest_eigenvalue(g)).epsilon(1e-6));
  }
}

TEST_CASE(
    "Errata: gains [1, 0.33, 0.45] have poles -1.0482 and 0.634 +- 0.165 i, and [1, 1, 0] a triple pole at "
    "0") {
  const auto z = poles({1.0, 0.33, 0.45});
  CHECK(z[0].real() == Approx(-1.0482).margin(5e-5));
  CHECK(z[1].real() == Approx(0.634).margin(5e-4));
  CHECK(std::abs(z[1].imag()) == Approx(0.165).margin(5e-4));
  CHECK(z[2] == std::conj(z[1]));
  CHECK_FALSE(stable({1.0, 0.33, 0.45}));
  CHECK(largest_pole({1.0, 1.0, 0.0}) == Approx(0.0).margin(1e-6));
}

TEST_CASE(
    "Errata: (5.25) is sufficient, not necessary: the thesis's optimum with K_d = 0 is stable, so is a "
    "negative K_d") {
  CHECK(stable({0.99990, 0.32798, 0.0}));
  CHECK(stable({1.0, 0.3, -0.1}));
  RandomStream random(14, Purpose::kTest);
  for (int trial = 0; trial < 20000; ++trial) {
    const Gains g{2.0 * random.uniform(), 4.0 * random.uniform(), random.uniform()};
    if (g.kp > 0 && g.ki_star > 0 && g.kd_star > 0 && 0.5 * g.kp + 0.25 * g.ki_star + g.kd_star < 1)
      CHECK(stable(g));
  }
}

TEST_CASE(
    "The exact stable set is what a simulation of 5,000 steps finds, half of the gains near the boundary") {
  const std::vector<std::size_t> triples = test::long_cases(200'000, 2'000);
  int mismatches = 0, inside = 0;
  for (const std::size_t n : triples) {
    RandomStream random(15, Purpose::kTest, std::uint32_t(n));
    const std::uint32_t kind = random.below(4);
    const double distance = (kind < 2 ? 1.0 : -1.0) * 1e-3 * std::pow(10.0, -2.0 * random.uniform());
    Gains g = kind % 2 ? some_gains(random) : near_boundary(random, distance);
    // A pole that near to the circle does not show in 5,000 steps.
    while (std::abs(largest_eigenvalue(g) - 1.0) < 3e-6) g = some_gains(random);
    inside += stable(g);
    mismatches += stable(g) != dies_out(g);
  }
  CHECK(mismatches == 0);
  CHECK(inside > int(triples.size() / 5));
  CHECK(inside < int(triples.size() * 4 / 5));
}

TEST_CASE("A print's disturbance comes back from its errors and actions") {
  const std::vector<double> d = disturbance({50, 0.5, 20, 0.2, 10, 0.1, 1, 7});
  std::vector<double> e(d.size()), u(d.size());
  simulate({1.0, 0.33, 0.02}, d, e, u);
  const auto found = disturbance_of(e, u);
  REQUIRE(found.size() == d.size() - 1);
  for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k] == Approx(d[k]).margin(1e-12));
  CHECK_THROWS_AS(disturbance_of(std::vector<double>{1.0}, std::vector<double>{}), std::invalid_argument);
}
