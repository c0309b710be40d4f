#include "core/grid/cosine_transform.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"

using namespace firn;

TEST_CASE("The inverse cosine transform undoes the forward one, of any size") {
  RandomStream random(1, Purpose::kTest);
  for (const auto& [nx, ny] :
       std::vector<std::pair<int, int>>{{1, 1}, {1, 7}, {5, 1}, {8, 8}, {23, 40}, {41, 6}}) {
    std::vector<double> values(std::size_t(nx * ny)), original;
    for (double& v : values) v = random.uniform(-1.0, 1.0);
    original = values;
    CosineTransform t(nx, ny);
    t.forward(values.data());
    t.inverse(values.data());
    for (std::size_t n = 0; n < values.size(); ++n) CHECK(values[n] == Approx(original[n]).margin(1e-13));
  }
}

TEST_CASE("A cosine between reflecting walls is one frequency, of its own amplitude") {
  const int nx = 12, ny = 9;
  std::vector<double> values;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i)
      values.push_back(std::cos(std::numbers::pi * 3 * (i + 0.5) / nx) *
                       std::cos(std::numbers::pi * 2 * (j + 0.5) / ny));
  CosineTransform(nx, ny).forward(values.data());
  for (std::size_t n = 0; n < values.size(); ++n)
    CHECK(values[n] == Approx(n == 2 * nx + 3 ? 0.5 * std::sqrt(double(nx * ny)) : 0.0).margin(1e-12));
}

TEST_CASE("The second difference of a frequency is its eigenvalue") {
  const int n = 10;
  const double dx = 0.3;
  const std::vector<double> eigenvalues = CosineTransform::eigenvalues(n, dx);
  for (int k = 0; k < n; ++k) {
    const auto wave = [&](int i) {
      const int inside = i < 0 ? -1 - i : i >= n ? 2 * n - 1 - i : i;  // reflecting walls
      return std::cos(std::numbers::pi * k * (inside + 0.5) / n);
    };
    for (int i = 0; i < n; ++i)
      CHECK((wave(i + 1) - 2.0 * wave(i) + wave(i - 1)) / (dx * dx) ==
            Approx(-eigenvalues[std::size_t(k)] * wave(i)).margin(1e-11));
  }
}
