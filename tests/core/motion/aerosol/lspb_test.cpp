#include "core/motion/aerosol/lspb.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/motion/aerosol/oracle.h"

using namespace firn::motion;
using namespace firn::test;

namespace {

constexpr double kAlpha = 30.0, kVmax = 4.0, kNoLimit = 1e9;

// (15), (16) as the paper prints them: t1 + t0 in the denominator.
double printed_15(const AxisEnds& e, double t0, double t1) {
  return (kAlpha * (e.q1_mm - e.q0_mm) + 0.5 * (e.v0_mm_s * e.v0_mm_s - e.v1_mm_s * e.v1_mm_s)) /
         (e.v0_mm_s - e.v1_mm_s + kAlpha * (t1 + t0));
}

AxisEnds shifted(AxisEnds e, double by) {
  e.q0_mm += by;
  e.q1_mm += by;
  return e;
}

}  // namespace

TEST_CASE(
    "Equations (1) to (7), (18): each valid LSPB candidate meets all boundary conditions, by numeric "
    "integration",
    "[aerosol]") {
  Numbers next(1);
  int valid = 0;
  for (int n = 0; n < 400; ++n) {
    const AxisEnds e = random_ends(next, 1.5, kVmax);
    const double t0 = next(-2, 2), t1 = t0 + next(0.05, 1.5);
    for (const auto& p : lspb_candidates(e, t0, t1, kAlpha)) {
      if (!p) continue;
      ++valid;
      CHECK(p->t0_s == t0);
      CHECK(p->t1_s == t1);
      CHECK((t0 <= p->tb0_s && p->tb0_s <= p->tb1_s && p->tb1_s <= t1));
      CHECK(p->position(t0) == e.q0_mm);
      CHECK(p->position(t1) == e.q1_mm);
      CHECK(p->velocity(t0) == Approx(e.v0_mm_s).margin(1e-7));
      CHECK(p->velocity(t1) == Approx(e.v1_mm_s).margin(1e-7));
      CHECK(integrated_end(*p) == Approx(e.q1_mm).margin(1e-5));
      for (double t : {p->tb0_s, p->tb1_s}) {  // nothing jumps where a blend ends
        CHECK(p->position(t - 1e-9) == Approx(p->position(t + 1e-9)).margin(1e-7));
        CHECK(p->velocity(t - 1e-9) == Approx(p->velocity(t + 1e-9)).margin(1e-6));
      }
    }
  }
  CHECK(valid > 100);
}

TEST_CASE(
    "LSPB has a solution exactly when the time lets an axis with this acceleration arrive, and all solutions "
    "are one motion",
    "[aerosol]") {
  Numbers next(2);
  int solved = 0, none = 0;
  for (int n = 0; n < 3000; ++n) {
    const AxisEnds e = random_ends(next, 1.0, kVmax);
    const double t1 = next(0.01, 0.8);
    const auto [low, high] = reachable(e, t1, {kNoLimit, kAlpha});
    const double dq = e.q1_mm - e.q0_mm;
    if (std::min(std::abs(dq - low), std::abs(dq - high)) < 1e-5)
      continue;  // nearer than the oracle can tell
    const auto p = lspb(e, 0.0, t1, kAlpha);
    CAPTURE(e.q0_mm, e.q1_mm, e.v0_mm_s, e.v1_mm_s, t1);
    REQUIRE(p.has_value() == (low <= dq && dq <= high));
    ++(p ? solved : none);
    for (const auto& other : lspb_candidates(e, 0.0, t1, kAlpha))
      if (other)
        for (double part : {0.1, 0.35, 0.6, 0.9})
          CHECK(other->position(part * t1) == Approx(p->position(part * t1)).margin(1e-9));
  }
  CHECK(solved > 500);
  CHECK(none > 500);
}

TEST_CASE(
    "Erratum (9), (15), (16): t1 - t0 makes the solution independent of when the move starts, and the "
    "printed t1 "
    "+ t0 does not",
    "[aerosol]") {
  Numbers next(3);
  int one_sided = 0, printed_differs = 0, solvable = 0;
  for (int n = 0; n < 5000; ++n) {
    const AxisEnds e = random_ends(next, 1.0, kVmax);
    const double dt = next(0.02, 0.6), t0 = next(0.1, 3.0);
    const auto at_zero = lspb(e, 0.0, dt, kAlpha), later = lspb(e, t0, t0 + dt, kAlpha);
    REQUIRE(at_zero.has_value() == later.has_value());
    if (!at_zero) continue;
    ++solvable;
    CHECK(later->vc_mm_s == Approx(at_zero->vc_mm_s).margin(1e-6));
    const auto third = lspb_candidates(e, t0, t0 + dt, kAlpha)[4];
    if (!third) continue;
    ++one_sided;
    printed_differs += std::abs(printed_15(e, t0, t0 + dt) - third->vc_mm_s) > 1e-3;
  }
  CHECK(solvable > 1000);
  CHECK(one_sided > 100);
  CHECK(printed_differs > one_sided * 9 / 10);
}

TEST_CASE("Equation (8): the sign of the axis and the place of the origin do not matter", "[aerosol]") {
  Numbers next(4);
  for (int n = 0; n < 1000; ++n) {
    const AxisEnds e = random_ends(next, 1.0, kVmax), mirror{-e.q0_mm, -e.q1_mm, -e.v0_mm_s, -e.v1_mm_s};
    const double t1 = next(0.05, 0.6);
    const auto p = lspb(e, 0.0, t1, kAlpha), m = lspb(mirror, 0.0, t1, kAlpha),
               s = lspb(shifted(e, 25.0), 0.0, t1, kAlpha);
    REQUIRE(p.has_value() == m.has_value());
    if (!p) continue;
    CHECK(m->position(0.4 * t1) == Approx(-p->position(0.4 * t1)).margin(1e-9));
    if (s) CHECK(s->position(0.4 * t1) - 25.0 == Approx(p->position(0.4 * t1)).margin(1e-7));
  }
}

TEST_CASE("LSPB never gives a number that is none: no time, no distance, no speed", "[aerosol]") {
  for (double v0 : {-3.0, 0.0, 3.0})
    for (double v1 : {-3.0, 0.0, 3.0})
      for (double dq : {-0.5, 0.0, 0.5})
        for (double t1 : {0.0, 1e-12, 0.2, 1.0})
          if (const auto p = lspb({0.0, dq, v0, v1}, 0.0, t1, kAlpha)) {
            CHECK(std::isfinite(p->vc_mm_s));
            CHECK(std::isfinite(p->position(0.5 * t1)));
            CHECK((p->tb0_s >= 0 && p->tb0_s <= p->tb1_s && p->tb1_s <= t1));
          }
}
