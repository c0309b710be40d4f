#include "core/control/surface/adaptive_surface.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/control/surface/smf_surface.h"
#include "core/grid/random.h"

namespace firn::control {
namespace {

const GridSpec kGrid{16, 12, 1.0, 1.0, 0.0, 0.0};
constexpr double kInterval_mm = 1.2;

SurfaceOptions options(const char* scheme) {
  SurfaceOptions o;
  o.scheme = scheme;
  o.interval_mm = kInterval_mm;
  o.version = SurfaceVersion::kValveFrequency;
  o.smf = {1.0, 0.33, 0.0, 0.5};
  return o;
}

/// RMS error [intervals] over the last third of `n` intervals of e_{k+1} = e_k - u_k - d_k(c), measured with
/// noise.
double rms(SurfaceController& s, int n, double noise, std::uint64_t seed,
           const std::function<double(int, std::size_t)>& d) {
  const Grid<std::uint8_t> part(kGrid, 1);
  HeightMap e(kGrid, 0.0), h(kGrid);
  double squares = 0.0, count = 0.0;
  for (int k = 1; k <= n; ++k) {
    for (std::size_t c = 0; c < e.size(); ++c)
      h.cells[c] = kInterval_mm *
                   (k - e.cells[c] +
                    noise * random_normal({seed, Purpose::kTest, std::uint32_t(k), 1, std::uint32_t(c)}));
    const SurfaceDecision a = s.decide({h, part, k * kInterval_mm, 5 * k, 0, 0.0});
    for (std::size_t c = 0; c < e.size(); ++c) {
      e.cells[c] -= a.u.cells[c] + d(k, c);
      if (3 * k > 2 * n) {
        squares += e.cells[c] * e.cells[c];
        count += 1.0;
      }
    }
  }
  return std::sqrt(squares / count);
}

}  // namespace

TEST_CASE("At a constant gain and without saturation the adaptive scheme is the PI law of the thesis") {
  SurfaceOptions a = options("smf_adaptive"), b = options("smf");
  a.adaptive.gain = a.adaptive.gain_min = a.adaptive.gain_max = 0.33;
  b.smf.integral_limit = 1000.0;
  // With D_k = D_{k-1} + g (e_{k-1} - u_{k-1} - D_{k-1} - e_k) and u = e - D the innovation is -e_k: D = -g
  // sum e.
  AdaptiveSurface adaptive(a);
  SmfSurface pi(b);
  const Grid<std::uint8_t> part(kGrid, 1);
  HeightMap e(kGrid, 0.0), h(kGrid);
  for (int k = 1; k <= 20; ++k) {
    for (std::size_t c = 0; c < e.size(); ++c) h.cells[c] = kInterval_mm * (k - e.cells[c]);
    const SurfaceMeasurement m{h, part, k * kInterval_mm, 5 * k, 0, 0.0};
    const SurfaceDecision x = adaptive.decide(m), y = pi.decide(m);
    for (std::size_t c = 0; c < e.size(); ++c) {
      REQUIRE(x.u.cells[c] == Approx(y.u.cells[c]).margin(1e-9));
      e.cells[c] -= x.u.cells[c] +
                    0.1 * (random_uniform({3, Purpose::kTest, 0, std::uint32_t(k), std::uint32_t(c)}) - 0.5);
    }
  }
}

TEST_CASE(
    "A lasting pattern of places that get too little is learned place by place, and saturation does not wind "
    "it up") {
  const auto pattern = [](int, std::size_t c) { return 0.15 * std::sin(0.4 * double(c % 16)); };
  AdaptiveSurface s(options("smf_adaptive"));
  CHECK(rms(s, 60, 0.0, 1, pattern) < 1e-3);
  for (std::size_t c = 0; c < kGrid.size(); ++c)
    CHECK(s.disturbance().cells[c] == Approx(pattern(0, c)).margin(5e-3));

  SurfaceOptions o = options("smf_adaptive");
  AdaptiveSurface t(o);
  const Grid<std::uint8_t> part(kGrid, 1);
  double e = 0.0;
  int over = 0;
  for (int k = 1; k <= 40; ++k) {
    const HeightMap h(kGrid, kInterval_mm * (k - e));
    const double u = t.decide({h, part, k * kInterval_mm, 5 * k, 0, 0.0}).u.cells[0];
    e -= u + (k < 10 ? 1.5 : 0.0);  // nine intervals that no action can hold
    if (k > 25 && std::abs(e) > 0.02) ++over;
  }
  CHECK(over == 0);
}

TEST_CASE("The gain falls where maps only scatter and rises where the disturbance drifts") {
  AdaptiveSurface s(options("smf_adaptive"));
  const auto d = [](int k, std::size_t c) { return int(c % 16) < 8 ? 0.0 : 0.02 * k; };
  const auto noise = [](int k, std::size_t c) {  // common to the left half: a new height at each map
    return int(c % 16) < 8 ? 0.1 * (random_uniform({5, Purpose::kTest, 0, 0, std::uint32_t(k)}) - 0.5) : 0.0;
  };
  HeightMap e(kGrid, 0.0), h(kGrid);
  const Grid<std::uint8_t> part(kGrid, 1);
  for (int k = 1; k <= 25; ++k) {
    for (std::size_t c = 0; c < e.size(); ++c) h.cells[c] = kInterval_mm * (k - e.cells[c] + noise(k, c));
    const SurfaceDecision a = s.decide({h, part, k * kInterval_mm, 5 * k, 0, 0.0});
    for (std::size_t c = 0; c < e.size(); ++c) e.cells[c] -= a.u.cells[c] + d(k, c);
  }
  CHECK(s.gain().at(1, 6) < 0.33);
  CHECK(s.gain().at(14, 6) > 0.33);
}

TEST_CASE(
    "With noisy maps of a lasting pattern the adaptive scheme ends nearer than the thesis's gains, over 20 "
    "seeds") {
  int better = 0;
  double adaptive = 0.0, thesis = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto d = [&](int, std::size_t c) { return 0.1 * std::sin(0.4 * double(c % 16) + double(seed)); };
    SurfaceOptions o = options("smf");
    o.smf = {1.0, 0.25, 0.25, 0.5};
    AdaptiveSurface a(options("smf_adaptive"));
    SmfSurface b(o);
    const double x = rms(a, 27, 0.04, seed, d), y = rms(b, 27, 0.04, seed, d);
    adaptive += x / 20.0;
    thesis += y / 20.0;
    better += x < y;
  }
  CHECK(better == 20);
  CHECK(adaptive < 0.95 * thesis);
}

}  // namespace firn::control
