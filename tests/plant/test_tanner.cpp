// The spreading of a drop, which takes a thin film the longest to compute.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "plant/film/film_flow.h"

using namespace firn::plant;

TEST_CASE("A drop on a film of a hundredth of its height spreads as the reference run of Tanner's law") {
  // Dimensionless: surface tension = viscosity = 1. The exponent is 0.111 to 0.114 there, and not 0.1.
  const int n = 40;
  const double b = 0.01, d = 4.0 / n;
  FilmFlow film({n, n, d, d}, {1.0 / 3.0, 0.0, MobilityPower::kThree, false, 1e-4, 1e-6});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) * d, y = (j + 0.5) * d;
      film.height()[std::size_t(j * n + i)] = b + std::max(0.0, 1.0 - x * x - y * y);
    }
  const double above =
      4.0 * (std::accumulate(film.height().begin(), film.height().end(), 0.0) - b * n * n) * d * d;
  const auto radius = [&] { return std::sqrt(2.0 * above / (std::numbers::pi * (film.height()[0] - b))); };
  film.flow(100.0);
  CHECK(radius() == Approx(1.896).epsilon(0.012));
  film.flow(900.0);
  CHECK(radius() == Approx(2.458).epsilon(0.006));
}
