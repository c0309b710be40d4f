#include "core/control/lines/visible_width.h"

#include <catch2/catch.hpp>
#include <cmath>

using firn::control::VisibleWidth;

namespace {

constexpr double kLookSigma_mm = 0.03, kLookDepth_mm = 0.002;

// The same by the library's exp and log.
double look_of(double section_mm2) {
  const double a = section_mm2 / (std::sqrt(2.0 * 3.14159265358979324) * kLookSigma_mm * kLookDepth_mm),
               half = -std::log(0.5 * (1.0 + std::exp(-a)));
  return 2.0 * kLookSigma_mm * std::sqrt(2.0 * std::log(a / half));
}

}  // namespace

TEST_CASE(
    "The visible width of a section is that of the closed form, and the section of a width its inverse") {
  const VisibleWidth v(kLookSigma_mm, kLookDepth_mm);
  for (double section_mm2 = 1e-5; section_mm2 < 0.1; section_mm2 *= 1.7) {
    CAPTURE(section_mm2);
    CHECK(v.width_mm(section_mm2) == Approx(look_of(section_mm2)).epsilon(1e-9));
    CHECK(v.section_mm2(v.width_mm(section_mm2)) == Approx(section_mm2).epsilon(1e-6));
  }
}

TEST_CASE("A thin line looks as wide as its section at half height") {
  CHECK(VisibleWidth(kLookSigma_mm, kLookDepth_mm).width_mm(2e-7) ==
        Approx(2.3548 * kLookSigma_mm).epsilon(1e-3));
}
