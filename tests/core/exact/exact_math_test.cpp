#include "core/exact/exact_math.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/grid/random.h"

using namespace firn;

namespace {

/// Error in units of the last place of the true value, which long double tells to 11 bits more.
double ulps(double found, long double truth) {
  const double near = std::abs(double(truth));
  const double ulp = std::nextafter(near, std::numeric_limits<double>::infinity()) - near;
  return std::abs(double((static_cast<long double>(found) - truth) / ulp));
}

bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

}  // namespace

TEST_CASE("exact functions lie within one unit of the last place", "[exact][seeded]") {
  RandomStream random(53, Purpose::kTest);
  double worst = 0.0;
  const auto take = [&](double found, long double truth) { worst = std::max(worst, ulps(found, truth)); };
  for (int n = 0; n < 30'000; ++n) {
    const double scale = std::exp2(random.uniform(-20.0, 6.0)), x = random.uniform(-scale, scale),
                 y = random.uniform(-scale, scale);
    CAPTURE(x, y);
    take(exact::sin(x), std::sin(static_cast<long double>(x)));
    take(exact::cos(x), std::cos(static_cast<long double>(x)));
    take(exact::tan(x), std::tan(static_cast<long double>(x)));
    take(exact::cbrt(x), std::cbrt(static_cast<long double>(x)));
    take(exact::atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x)));
    const exact::SinCos both = exact::sincos(x);
    take(both.sin, std::sin(static_cast<long double>(x)));
    take(both.cos, std::cos(static_cast<long double>(x)));
    REQUIRE(worst <= 1.0);
  }
}

TEST_CASE("the larger of a number and a cube root is that of the root itself, to the last bit",
          "[exact][seeded]") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                   kNone = std::numeric_limits<double>::quiet_NaN();
  const auto check = [](double least, double x) {
    CAPTURE(least, x);
    CHECK(same(exact::max_with_cbrt(least, x), std::max(least, exact::cbrt(x))));
  };
  RandomStream random(54, Purpose::kTest);
  for (int n = 0; n < 30'000; ++n) {
    const double least = std::exp2(random.uniform(-300.0, 300.0));
    double x = least * least * least * (n % 3 ? 1.0 : random.uniform(0.0, 2.0));
    for (int step = 0; step < n % 9; ++step) x = std::nextafter(x, n % 2 ? kInfinity : 0.0);
    check(least, x);
  }
  for (const double least : {0.0, 5e-324, 1.0, 1e103, kInfinity})
    for (const double x :
         {0.0, -8.0, 5e-324, 1.0, std::nextafter(1.0, 2.0), 1e308, kInfinity, -kInfinity, kNone})
      check(least, x);
}

TEST_CASE("exact functions are as C has them at zeros, infinities and the axes", "[exact]") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double zero : {0.0, -0.0}) {
    CHECK(same(exact::sin(zero), zero));
    CHECK(same(exact::tan(zero), zero));
    CHECK(same(exact::cbrt(zero), zero));
    CHECK(exact::cos(zero) == 1.0);
  }
  for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity})
    for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity}) {
      CAPTURE(y, x);
      CHECK(same(exact::atan2(y, x), std::atan2(y, x)));
    }
  for (const double end : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(std::isnan(exact::sin(end)));
    CHECK(std::isnan(exact::cos(end)));
    CHECK(std::isnan(exact::tan(end)));
    CHECK(std::isnan(exact::sincos(end).sin));
  }
  CHECK(exact::cbrt(-27.0) == -3.0);
}

TEST_CASE("exact functions give these bytes on every x86-64 CPU", "[exact]") {
  RandomStream random(54, Purpose::kTest);
  std::uint64_t all = 0;
  const auto take = [&](double v) { all = std::rotl(all, 7) ^ std::bit_cast<std::uint64_t>(v); };
  for (int n = 0; n < 5'000; ++n) {
    const double x = random.uniform(-10.0, 10.0), y = random.uniform(-10.0, 10.0);
    take(exact::sin(x));
    take(exact::cos(x));
    take(exact::tan(x));
    take(exact::cbrt(x));
    take(exact::atan2(y, x));
    const exact::SinCos both = exact::sincos(y);
    take(both.sin);
    take(both.cos);
  }
  CHECK(all == 0xd3c96c78ddbaf809u);
}
