#include "core/control/surface/disturbance_observer_surface.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "core/control/surface/smf_surface.h"
#include "core/grid/random.h"

namespace firn::control {
namespace {

const GridSpec kObserverGrid{24, 20, 1.0, 1.0, 0.0, 0.0};
constexpr double kObserverInterval_mm = 1.2;

SurfaceOptions observer_options(const char* scheme) {
  SurfaceOptions o;
  o.scheme = scheme;
  o.interval_mm = kObserverInterval_mm;
  o.version = SurfaceVersion::kValveFrequency;
  o.smf = {1.0, 0.25, 0.25, 0.5};
  return o;
}

/// Part in the middle, scaffold about it, bare at the grid's border and in a bore.
Grid<std::uint8_t> footprint() {
  Grid<std::uint8_t> m(kObserverGrid);
  for (int j = 1; j < kObserverGrid.ny - 1; ++j)
    for (int i = 1; i < kObserverGrid.nx - 1; ++i) m.at(i, j) = i < 5 || i > 18 || j < 4 || j > 15 ? 2 : 1;
  m.at(11, 9) = m.at(12, 9) = 0;
  return m;
}

using Disturbance = std::function<double(int k, std::size_t cell)>;

/// Errors [intervals] of e_{k+1} = e_k - u_k - d_k on the footprint; the map has noise. RMS over the last
/// third.
double observer_rms(SurfaceController& s, int n, double noise, std::uint64_t seed, const Disturbance& d) {
  const Grid<std::uint8_t> material = footprint();
  HeightMap e(kObserverGrid, 0.0), h(kObserverGrid);
  double squares = 0.0, count = 0.0;
  for (int k = 1; k <= n; ++k) {
    for (std::size_t c = 0; c < e.size(); ++c)
      h.cells[c] = kObserverInterval_mm *
                   (k - e.cells[c] +
                    noise * random_normal({seed, Purpose::kTest, std::uint32_t(k), 1, std::uint32_t(c)}));
    const SurfaceDecision a = s.decide({h, material, k * kObserverInterval_mm, 5 * k, 0, 0.0});
    for (std::size_t c = 0; c < e.size(); ++c) {
      if (!material.cells[c]) continue;
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

TEST_CASE("A cell's zone is that of its nearest cell of another kind, as a search over all cells finds it") {
  RandomStream random(4, Purpose::kTest);
  for (int round = 0; round < 20; ++round) {
    Grid<std::uint8_t> m(kObserverGrid);
    const double x = 24.0 * random.uniform(), y = 20.0 * random.uniform(), r = 4.0 + 8.0 * random.uniform();
    for (int j = 0; j < kObserverGrid.ny; ++j)
      for (int i = 0; i < kObserverGrid.nx; ++i) {
        const double d = std::sqrt((i - x) * (i - x) + (j - y) * (j - y));
        m.at(i, j) = d < r ? 1 : d < r + 4.0 ? 2 : 0;
      }
    const double band = 0.8 + random.uniform();
    const Grid<std::int8_t> zone = zones(m, band);
    for (int j = 0; j < kObserverGrid.ny; ++j)
      for (int i = 0; i < kObserverGrid.nx; ++i) {
        if (!m.at(i, j)) {
          CHECK(zone.at(i, j) == -1);
          continue;
        }
        double nearest = std::numeric_limits<double>::infinity();
        bool bare = false;
        for (int b = -8; b < kObserverGrid.ny + 8; ++b)
          for (int a = -8; a < kObserverGrid.nx + 8; ++a) {
            const std::uint8_t other = kObserverGrid.contains(a, b) ? m.at(a, b) : std::uint8_t(0);
            const double d = std::sqrt(double((a - i) * (a - i) + (b - j) * (b - j)));
            if (other != m.at(i, j) && (d < nearest || (d == nearest && other == 0))) {
              nearest = d;
              bare = other == 0;
            }
          }
        const int wanted = std::min(kZoneBands - 1, int(nearest / band));
        REQUIRE(zone.at(i, j) % kZoneBands == wanted);
        CHECK(zone.at(i, j) / kZoneBands / 2 == m.at(i, j) - 1);
        if (nearest < band * (kZoneBands - 1)) CHECK((zone.at(i, j) / kZoneBands % 2 == 1) == bare);
      }
  }
}

TEST_CASE(
    "With all that is foreseen off the action is K_p times the error, its narrow part by its own share") {
  SurfaceOptions o = observer_options("smf_foresee");
  o.foresee = {0.9, 0.0, 0.0, 1.0, 0.0, 9.0, 0.5, 5.0};
  DisturbanceObserverSurface s(o);
  const Grid<std::uint8_t> material = footprint();
  for (int k = 1; k <= 4; ++k) {
    HeightMap e(kObserverGrid, kNotMeasured), h(kObserverGrid, 0.0);
    for (std::size_t c = 0; c < e.size(); ++c)
      if (material.cells[c]) {
        e.cells[c] = 0.2 * (random_uniform({8, Purpose::kTest, 0, std::uint32_t(k), std::uint32_t(c)}) - 0.5);
        h.cells[c] = kObserverInterval_mm * (k - e.cells[c]);
      }
    const SurfaceDecision a = s.decide({h, material, k * kObserverInterval_mm, 5 * k, 0, 0.0});
    const HeightMap about = square_mean(e, 5.0);
    for (std::size_t c = 0; c < e.size(); ++c)
      if (material.cells[c])
        REQUIRE(a.u.cells[c] == Approx(0.9 * (0.5 * about.cells[c] + 0.5 * e.cells[c])).margin(1e-9));
  }
}

TEST_CASE(
    "What lasts in a material, along a border or at a place is foreseen, and a valve that drifts is "
    "followed") {
  const Grid<std::int8_t> zone = zones(footprint(), 1.0);
  const Grid<std::uint8_t> material = footprint();
  const Disturbance lasting = [&](int, std::size_t c) {
    return (material.cells[c] == 1 ? 0.1 : -0.05) + (zone.cells[c] % kZoneBands == 1 ? 0.08 : 0.0) +
           0.05 * std::sin(0.25 * double(c % 24));
  };
  SurfaceOptions o = observer_options("smf_foresee");
  o.foresee.wide_gain = 0.3;
  o.foresee.wide_mm = 1.0;  // a place is a cell
  DisturbanceObserverSurface s(o);
  CHECK(observer_rms(s, 60, 0.0, 1, lasting) < 1e-3);
  for (std::size_t c = 0; c < kObserverGrid.size(); ++c)
    if (material.cells[c]) CHECK(s.disturbance().cells[c] == Approx(lasting(0, c)).margin(2e-3));

  // 20 % more in the end, within two hours of 40-minute intervals: PID [1, 0.25, 0.25] lags behind by more.
  const Disturbance drift = [&](int k, std::size_t c) {
    return material.cells[c] == 1 ? -0.2 * (1.0 - std::pow(0.72, k)) : 0.2 * (1.0 - std::pow(0.72, k));
  };
  double worst[2]{};
  for (int scheme = 0; scheme < 2; ++scheme)
    for (int n = 6; n <= 12; n += 3)
      worst[scheme] =
          std::max(worst[scheme],
                   observer_rms(*make_surface_controller(observer_options(scheme ? "smf_foresee" : "smf")), n,
                                0.0, 1, drift));
  CHECK(worst[1] < 0.6 * worst[0]);
}

TEST_CASE(
    "Roughness that is new in every interval is answered once: nearer than the thesis's gains for 20 of 20 "
    "seeds") {
  const Grid<std::uint8_t> material = footprint();
  int better = 0;
  double foresee = 0.0, thesis = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Disturbance d = [&](int k, std::size_t c) {
      return 0.08 * random_normal({seed, Purpose::kTest, std::uint32_t(k), 2, std::uint32_t(c)}) +
             (material.cells[c] == 1 ? 0.05 : 0.0);
    };
    const double x = observer_rms(*make_surface_controller(observer_options("smf_foresee")), 27, 0.01, seed,
                                  d),
                 y = observer_rms(*make_surface_controller(observer_options("smf")), 27, 0.01, seed, d);
    foresee += x / 20.0;
    thesis += y / 20.0;
    better += x < y;
  }
  CHECK(better == 20);
  CHECK(foresee < 0.95 * thesis);
  CHECK(foresee > 0.08);  // nothing foretells the roughness itself
}

TEST_CASE("A surface measured again takes the first map's place in what the scheme remembers") {
  DisturbanceObserverSurface once(observer_options("smf_foresee")), twice(observer_options("smf_foresee"));
  const Grid<std::uint8_t> material = footprint();
  for (int k = 1; k <= 6; ++k) {
    HeightMap h(kObserverGrid), wrong(kObserverGrid);
    for (std::size_t c = 0; c < h.size(); ++c) {
      h.cells[c] =
          kObserverInterval_mm *
          (k - 0.1 * (random_uniform({9, Purpose::kTest, 0, std::uint32_t(k), std::uint32_t(c)}) - 0.5));
      wrong.cells[c] = h.cells[c] + 0.3;
    }
    twice.decide({wrong, material, k * kObserverInterval_mm, 5 * k, 0, 0.0});
    const HeightMap a = once.decide({h, material, k * kObserverInterval_mm, 5 * k, 0, 0.0}).u,
                    b = twice.decide({h, material, k * kObserverInterval_mm, 5 * k, 1, 0.0}).u;
    REQUIRE(a.cells == b.cells);
  }
}

TEST_CASE(
    "The bare table's map is answered once, with what borders will lack, and teaches nothing, and a valve's "
    "beginning drift is followed an interval sooner for it") {
  const Grid<std::uint8_t> material = footprint();
  const Grid<std::int8_t> zone = zones(material, 1.0);
  const auto lack = [&](std::size_t c) {
    return zone.cells[c] % kZoneBands == 1 ? 0.05 : zone.cells[c] % kZoneBands == 2 ? 0.025 : 0.0;
  };
  HeightMap table(kObserverGrid), level(kObserverGrid, kObserverInterval_mm);
  for (std::size_t c = 0; c < table.size(); ++c) table.cells[c] = 0.1 * std::sin(0.4 * double(c % 24)) - 0.05;
  DisturbanceObserverSurface s(observer_options("smf_foresee"));
  const SurfaceDecision first = s.decide({table, material, 0.0, 0, 0, 0.0});
  CHECK(first.kind == SurfaceDecision::Kind::kPrint);
  for (std::size_t c = 0; c < table.size(); ++c)
    if (material.cells[c])
      REQUIRE(first.u.cells[c] == Approx(lack(c) - table.cells[c] / kObserverInterval_mm).margin(1e-12));
  const SurfaceDecision next =
      s.decide({level, material, kObserverInterval_mm, 5, 0, 0.0});  // it came out as foreseen
  for (std::size_t c = 0; c < table.size(); ++c)
    if (material.cells[c]) REQUIRE(next.u.cells[c] == Approx(lack(c)).margin(1e-12));

  double error[2];
  for (const bool told : {false, true}) {
    DisturbanceObserverSurface law(observer_options("smf_foresee"));
    HeightMap e(kObserverGrid, 0.0), h(kObserverGrid);
    for (std::size_t c = 0; c < e.size(); ++c) e.cells[c] = -table.cells[c] / kObserverInterval_mm;
    for (int k = told ? 0 : 1; k <= 2; ++k) {
      if (!told && k == 1)
        for (double& each : e.cells) each -= 0.03;
      for (std::size_t c = 0; c < e.size(); ++c) h.cells[c] = kObserverInterval_mm * (k - e.cells[c]);
      if (k == 2) break;
      const SurfaceDecision a = law.decide({h, material, k * kObserverInterval_mm, 5 * k, 0, 0.0});
      for (std::size_t c = 0; c < e.size(); ++c)
        e.cells[c] -= a.u.cells[c] + (k == 0 ? 0.03 : 0.08);  // too little, and less and less
    }
    double squares = 0.0, cells = 0.0;
    for (std::size_t c = 0; c < e.size(); ++c)
      if (material.cells[c]) {
        squares += e.cells[c] * e.cells[c];
        cells += 1.0;
      }
    error[told] = std::sqrt(squares / cells);
  }
  CHECK(error[1] < 0.75 * error[0]);
}

TEST_CASE("Gains and lengths of what is foreseen are refused by name") {
  const auto refuses = [](const std::function<void(SurfaceForeseeOptions&)>& spoil, const char* name) {
    SurfaceOptions o = observer_options("smf_foresee");
    spoil(o.foresee);
    CHECK_THROWS_WITH(make_surface_controller(o), Catch::Contains(name));
  };
  refuses([](auto& f) { f.kp = 0.0; }, "foresee.kp");
  refuses([](auto& f) { f.flow_gain = 1.5; }, "foresee.flow_gain");
  refuses([](auto& f) { f.zone_gain = -0.1; }, "foresee.zone_gain");
  refuses([](auto& f) { f.wide_gain = std::nan(""); }, "foresee.wide_gain");
  refuses([](auto& f) { f.narrow_gain = 3.0; }, "foresee.narrow_gain");
  refuses([](auto& f) { f.zone_mm = 0.0; }, "foresee.zone_mm");
  refuses([](auto& f) { f.wide_mm = -1.0; }, "foresee.wide_mm");
  refuses([](auto& f) { f.narrow_mm = std::nan(""); }, "foresee.narrow_mm");
}

}  // namespace firn::control
