// The thin film against solutions in closed form: levelling, source solutions, gravity currents and a pinned
// drop.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/grid/random.h"
#include "plant/film/film_flow.h"
#include "plant/film/orchard.h"

using namespace firn;
using namespace firn::plant;

namespace {

constexpr double kInkSpeed_mm_s = 1500.0;  // surface tension 0.03 N/m by viscosity 0.02 Pa s

FilmLaw exact_law(double capillary, double gravity = 0.0, MobilityPower power = MobilityPower::kThree) {
  return {capillary, gravity, power, false, 1e-8, 1e-13};
}

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum;
}

/// Time constant of a wave of 1 % on a film, whose half period lies between two walls.
double levelling_s(double h_mm, double wave_mm, int points, double for_s) {
  const double k = 2.0 * std::numbers::pi / wave_mm;
  FilmLaw law = exact_law(kInkSpeed_mm_s / 3.0);
  law.absolute = 1e-9 * h_mm;
  FilmFlow film({points / 2, 1, wave_mm / points, 1.0}, law);
  const auto cosine = [&](int i) { return std::cos(k * (i + 0.5) * film.grid().dx); };
  const auto amplitude = [&] {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < points / 2; ++i) {
      sum += (film.height()[std::size_t(i)] - h_mm) * cosine(i);
      squares += cosine(i) * cosine(i);
    }
    return sum / squares;
  };
  for (int i = 0; i < points / 2; ++i) film.height()[std::size_t(i)] = h_mm * (1.0 + 0.01 * cosine(i));
  const double before = amplitude();
  film.flow(for_s);
  return for_s / std::log(before / amplitude());
}

/// Mean absolute error at time t1 of a film that is `exact(r, t0)` at t0, in a quadrant or on a half line of
/// length `size`, by the largest exact height.
double error_of(const std::function<double(double r, double t)>& exact, const FilmLaw& law, int cells,
                bool line, double size, double t0, double t1) {
  const double d = size / cells;
  FilmFlow film({cells, line ? 1 : cells, d, d}, law);
  const auto at = [&](std::size_t n, double t) {
    const double x = (double(n % std::size_t(cells)) + 0.5) * d,
                 y = line ? 0.0 : (double(n / std::size_t(cells)) + 0.5) * d;
    return exact(std::sqrt(x * x + y * y), t);
  };
  for (std::size_t n = 0; n < film.height().size(); ++n) film.height()[n] = at(n, t0);
  film.flow(t1 - t0);
  double error = 0.0, most = 0.0;
  for (std::size_t n = 0; n < film.height().size(); ++n) {
    error += std::abs(film.height()[n] - at(n, t1));
    most = std::max(most, at(n, t1));
  }
  return error / double(film.height().size()) / most;
}

double positive(double x) { return x > 0.0 ? x : 0.0; }

}  // namespace

TEST_CASE("A thin film levels a wave at Orchard's rate to 0.2 % at 32 points a wave") {
  for (const auto& [h_um, wave_mm, tau_ms] : std::vector<std::array<double, 3>>{
           {7.6, 0.263256, 14.041}, {7.6, 0.5265, 224.63}, {20.0, 0.5, 10.025}}) {
    CHECK(1.0 / orchard_thin_rate(kInkSpeed_mm_s, 1e-3 * h_um, 2.0 * std::numbers::pi / wave_mm) * 1e3 ==
          Approx(tau_ms).epsilon(5e-4));
    CHECK(levelling_s(1e-3 * h_um, wave_mm, 32, 1e-3 * tau_ms) * 1e3 == Approx(tau_ms).epsilon(2e-3));
  }
}

TEST_CASE("The error of a wave's rate falls at second order or better") {
  const double tau_s = 1.0 / orchard_thin_rate(kInkSpeed_mm_s, 7.6e-3, 2.0 * std::numbers::pi / 0.263256);
  const auto error = [&](int points) {
    return std::abs(levelling_s(7.6e-3, 0.263256, points, tau_s) / tau_s - 1.0);
  };
  CHECK(std::log2(error(8) / error(16)) > 1.8);
}

TEST_CASE("Lubrication theory overstates levelling by Orchard's ratio at any depth") {
  for (const auto& [x, ratio] : std::vector<std::array<double, 2>>{
           {0.091, 0.985}, {0.181, 0.944}, {0.251, 0.898}, {0.477, 0.710}, {1.19, 0.284}})
    CHECK(orchard_ratio(x) == Approx(ratio).margin(1.5e-3));
  CHECK(orchard_ratio(1e-3) == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("Source solutions of h_t + (h h_xxx)_x = 0 are met at order 1.8 or better") {
  const double a2 = 1.0;
  const auto line = [&](double x, double t) {
    return std::pow(t, -0.2) / 120.0 * std::pow(positive(a2 - x * x * std::pow(t, -0.4)), 2);
  };
  const auto round = [&](double r, double t) {
    return std::pow(t, -1.0 / 3) / 192.0 * std::pow(positive(a2 - r * r * std::pow(t, -1.0 / 3)), 2);
  };
  const FilmLaw law = exact_law(1.0, 0.0, MobilityPower::kOne);
  const double coarse = error_of(line, law, 20, true, 1.6, 1.0, 2.0),
               fine = error_of(line, law, 40, true, 1.6, 1.0, 2.0),
               finest = error_of(line, law, 80, true, 1.6, 1.0, 2.0);
  CHECK(finest < 1e-3);
  CHECK(std::log2(coarse / fine) > 1.8);
  CHECK(std::log2(fine / finest) > 1.8);
  const double c = error_of(round, law, 16, false, 1.6, 1.0, 2.0),
               f = error_of(round, law, 32, false, 1.6, 1.0, 2.0);
  CHECK(f < 1e-3);
  CHECK(std::log2(c / f) > 1.8);
}

TEST_CASE("Gravity currents follow Huppert's solutions") {
  constexpr double kFilm = 1e-3;  // ahead of the current
  const auto line = [&](double x, double t) {
    return kFilm + std::pow(t, -0.2) * std::cbrt(0.3 * positive(1.0 - x * x * std::pow(t, -0.4)));
  };
  const auto round = [&](double r, double t) {
    return kFilm + std::pow(t, -0.25) * std::cbrt(3.0 / 16 * positive(1.0 - r * r * std::pow(t, -0.25)));
  };
  const FilmLaw law = exact_law(0.0, 1.0);
  CHECK(error_of(line, law, 100, true, 1.6, 1.0, 4.0) < 0.01);
  CHECK(error_of(round, law, 40, false, 1.5, 1.0, 4.0) < 0.01);
  // A current of unit volume: its front by the volume of the solutions, x = 0.93107 t^(1/5), r = 0.89391
  // t^(1/8).
  const auto volume = [](const std::function<double(double)>& h, bool is_round) {
    double sum = 0.0;
    const int n = 200000;
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) / n;
      sum += h(x) * (is_round ? 2.0 * std::numbers::pi * x : 2.0) / n;
    }
    return sum;
  };
  const double of_line = volume([](double x) { return std::cbrt(0.3 * (1.0 - x * x)); }, false),
               of_round = volume([](double r) { return std::cbrt(3.0 / 16 * (1.0 - r * r)); }, true);
  CHECK(std::pow(of_line, -3.0 / 5) == Approx(0.93107).epsilon(1e-4));   // V ~ a^(5/3)
  CHECK(std::pow(of_round, -3.0 / 8) == Approx(0.89391).epsilon(1e-4));  // V ~ a^(8/3)
}

TEST_CASE("A pinned drop ends as a paraboloid") {
  const int n = 32;
  const double r_mm = 0.2065, v_mm3 = 527e-6, d = 0.45 / n;
  FilmFlow film({n, n, d, d}, {kInkSpeed_mm_s / 3.0});
  double cells = 0.0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) * d - 0.225, y = (j + 0.5) * d - 0.225;
      const bool inside = x * x + y * y < r_mm * r_mm;
      film.wet()[std::size_t(j * n + i)] = inside;
      cells += inside;
    }
  for (std::size_t c = 0; c < film.height().size(); ++c)
    film.height()[c] = film.wet()[c] ? v_mm3 / (cells * d * d) : 0.0;  // a disc of even thickness
  film.faces_changed(1.0);
  film.flow(10.0);
  double apex = 0.0;
  for (const double h : film.height()) apex = std::max(apex, h);
  CHECK(apex * 1e3 == Approx(7.863).epsilon(0.02));
  for (int i = 6; i < 26; ++i) {
    const double x = (i + 0.5) * d - 0.225;
    CHECK(film.height()[std::size_t(16 * n + i)] ==
          Approx(apex * (1.0 - x * x / (r_mm * r_mm))).margin(0.03 * apex));
  }
  // The slope of a paraboloid grows evenly to that of its contact line: taken over cells at 0.7 to 0.9 R.
  const std::size_t middle = std::size_t(16 * n + 16);
  double slope = 0.0;
  int counted = 0;
  for (std::size_t i = 10; i < 13; ++i, ++counted)
    slope += (film.height()[middle + i] - film.height()[middle + i + 1]) / d * r_mm / (double(i + 1) * d);
  CHECK(std::atan(slope / counted) * 180.0 / std::numbers::pi == Approx(4.364).epsilon(0.05));
  CHECK(sum_of(film.height()) * d * d == Approx(v_mm3).epsilon(1e-10));
}

TEST_CASE("A flat film stays as it is") {
  FilmFlow film({30, 20, 0.1, 0.1}, {500.0, 1.0, MobilityPower::kThree, true});
  for (double& h : film.height()) h = 0.0123;
  film.flow(100.0);
  for (const double h : film.height()) CHECK(h == Approx(0.0123).epsilon(1e-14));
}

TEST_CASE("A film on uneven ground with dry islands keeps its volume to 1e-10, and no cell falls below 0") {
  RandomStream random(9, Purpose::kTest);
  for (const bool full : {false, true}) {
    FilmFlow film({24, 31, 0.09, 0.08}, {500.0, 0.0, MobilityPower::kThree, full});
    for (std::size_t n = 0; n < film.height().size(); ++n) {
      film.ground()[n] = 0.02 * random.uniform();
      film.wet()[n] = random.uniform() < 0.8;
      film.height()[n] = film.wet()[n] ? 1e-4 + 0.01 * random.uniform() : 0.0;
    }
    film.faces_changed(0.15);
    const double before = sum_of(film.height());
    for (int n = 0; n < 6; ++n) film.flow(0.3);
    CHECK(sum_of(film.height()) == Approx(before).epsilon(1e-10));
    for (std::size_t n = 0; n < film.height().size(); ++n)
      CHECK((film.wet()[n] ? film.height()[n] > 0.0 : film.height()[n] == 0.0));
  }
}

TEST_CASE("Nothing flows over a step that is steeper than ink flows over") {
  FilmFlow film({20, 1, 0.1, 0.1}, {500.0});
  for (int i = 0; i < 20; ++i) {
    film.ground()[std::size_t(i)] = i < 10 ? 0.1 : 0.0;
    film.height()[std::size_t(i)] = 0.005;
  }
  film.faces_changed(0.3);
  film.flow(5.0);
  double high = 0.0;
  for (int i = 0; i < 10; ++i) high += film.height()[std::size_t(i)];
  CHECK(high == Approx(0.05).epsilon(1e-10));
}
