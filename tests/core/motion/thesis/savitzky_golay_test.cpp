#include "core/motion/thesis/savitzky_golay.h"

#include <catch2/catch.hpp>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::motion::thesis;

TEST_CASE("The 7-point filter passes cubics unchanged, at the ends too") {
  RandomStream random(21, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    const double a = random.normal(), b = random.normal(), c = random.normal(), d = random.normal();
    std::vector<double> x;
    for (int i = 0; i < 20; ++i) x.push_back(a + b * i + c * i * i + d * i * i * i);
    const auto y = savitzky_golay_7(x);
    for (std::size_t i = 0; i < x.size(); ++i) REQUIRE(y[i] == Approx(x[i]).epsilon(1e-11).margin(1e-9));
  }
}

TEST_CASE("Its weights are the classical (-2, 3, 6, 7, 6, 3, -2) / 21") {
  std::vector<double> pulse(15, 0.0);
  pulse[7] = 21.0;
  const auto y = savitzky_golay_7(pulse);
  const double expected[] = {0, 0, 0, 0, -2, 3, 6, 7, 6, 3, -2, 0, 0, 0, 0};
  for (std::size_t i = 3; i < 12; ++i) CHECK(y[i] == Approx(expected[i]).margin(1e-12));
  const double first_window[] = {39, 8, -4, -4, 1, 4, -2};  // of 42, at the first sample
  for (std::size_t k = 0; k < 7; ++k) {
    std::vector<double> unit(9, 0.0);
    unit[k] = 42.0;
    CHECK(savitzky_golay_7(unit)[0] == Approx(first_window[k]).margin(1e-12));
  }
}

TEST_CASE("Fewer samples than the window come back as they are") {
  const std::vector<double> x{1, 5, 2, 8};
  CHECK(savitzky_golay_7(x) == x);
}
