// The aerosol nozzle against conservation and closed forms.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/grid/random.h"
#include "plant/aerosol/deposit.h"
#include "plant/inkjet/optics.h"
#include "plant/twins/track.h"

using namespace firn;
using namespace firn::plant;

namespace {

AerosolParams steady() {
  AerosolParams p;
  p.wander = p.clog_per_h = p.blob_s = p.overspray = 0.0;
  p.tail_s = 0.005;
  p.open_delay_s = 0.03;
  p.close_delay_s = 0.045;
  return p;
}

constexpr double kSpeed_mm_s = 3.0;

/// A straight pass from x = 0.5 at constant speed, the shutter switched at two times.
void straight_pass(Deposit& d, double open_s, double close_s, double end_s) {
  const auto at = [](std::int64_t us) {
    return Deposit::Nozzle{0.5 + kSpeed_mm_s * double(us) * 1e-6, 1.0, kSpeed_mm_s};
  };
  d.catch_up(std::llround(open_s * 1e6), at);
  d.switch_shutter(true, std::llround(open_s * 1e6));
  d.catch_up(std::llround(close_s * 1e6), at);
  d.switch_shutter(false, std::llround(close_s * 1e6));
  d.catch_up(std::llround(end_s * 1e6), at);
}

const GridSpec kPlate{200, 100, 0.02, 0.02, 0.0, 0.0};

}  // namespace

TEST_CASE("Ink is conserved: what flowed has passed, is kept or gathers, and what passed has dried") {
  AerosolParams p = steady();
  p.blob_s = 0.02;
  p.overspray = 0.1;
  Deposit d(kPlate, p, 1);
  straight_pass(d, 0.2, 0.9, 1.2);
  const AerosolLedger& l = d.ledger();
  CHECK(l.passed_mm3 + l.kept_mm3 + d.source().gathered_mm3() == Approx(1.2 * p.flow_mm3_s).epsilon(1e-9));
  CHECK(l.landed_mm3 + l.lost_mm3 == Approx(p.solids * l.passed_mm3).epsilon(1e-9));
  CHECK(d.surface().volume_mm3() == Approx(l.landed_mm3).epsilon(1e-9));
}

TEST_CASE("A line's section is flow x solids / speed, its sigma that of beam and wet section") {
  AerosolParams p = steady();
  Deposit d(kPlate, p, 1);
  straight_pass(d, 0.1, 1.0, 1.2);
  const HeightMap h = d.surface().cell_means();
  double area = 0.0, second = 0.0;
  const int i = 100;  // x = 2 mm, in the middle
  for (int j = 0; j < kPlate.ny; ++j) {
    const double n = kPlate.y_mm(j) - 1.0, dh = h.at(i, j) * kPlate.pitch_y_mm;
    area += dh;
    second += n * n * dh;
  }
  CHECK(area == Approx(p.flow_mm3_s * p.solids / kSpeed_mm_s).epsilon(0.002));
  const double sigma = beam_sigma_mm(p), wet = p.flow_mm3_s / kSpeed_mm_s;
  // Cells of 20 um add a twelfth of their square.
  CHECK(second / area == Approx(sigma * sigma + p.spread * wet + 0.02 * 0.02 / 12.0).epsilon(0.02));
}

TEST_CASE("The shutter's delays and tails move a line's ends by delay plus tail times speed") {
  const AerosolParams p = steady();
  Deposit d(kPlate, p, 1);
  straight_pass(d, 0.1, 0.9, 1.2);
  // Volume between the switches' places: open for 0.8 s, late by 30 ms and long by 45 ms, tails alike.
  CHECK(d.ledger().passed_mm3 == Approx(p.flow_mm3_s * (0.8 - 0.03 + 0.045)).epsilon(1e-3));
  double sum = 0.0, first = 0.0;
  const HeightMap h = d.surface().cell_means();
  for (int i = 0; i < kPlate.nx; ++i)
    for (int j = 0; j < kPlate.ny; ++j) {
      sum += h.at(i, j);
      first += h.at(i, j) * kPlate.x_mm(i);
    }
  const double begin = 0.5 + kSpeed_mm_s * (0.1 + 0.03 + p.tail_s),
               end = 0.5 + kSpeed_mm_s * (0.9 + 0.045 + p.tail_s);
  CHECK(first / sum == Approx(0.5 * (begin + end)).margin(0.003));
}

TEST_CASE("The beam is narrower for more sheath gas, and none is wider than the nozzle") {
  AerosolParams p;
  double before = 0.25 * p.nozzle_mm;
  for (const double r : {0.2, 0.5, 1.0, 2.0, 5.0, 20.0}) {
    p.focusing_ratio = r;
    const double sigma = beam_sigma_mm(p);
    CHECK(sigma < before);
    // Flow within that share of the radius is the aerosol's.
    const double s2 = 16.0 * sigma * sigma / (p.nozzle_mm * p.nozzle_mm);
    CHECK(1.0 - (1.0 - s2) * (1.0 - s2) == Approx(1.0 / (1.0 + r)));
    before = sigma;
  }
}

TEST_CASE("The atomizer drifts as told, through the tube's lag, and the nozzle clogs exponentially") {
  AerosolParams p = steady();
  p.drift = 0.2;
  p.drift_s = 100.0;
  p.clog_per_h = 3.6;
  Source s(p, 1);
  s.step(60'000'000);
  const double ramp = 0.2 / 100.0 * (60.0 - p.tube_s);  // a first-order lag follows a ramp late by its time
  // dc/dt = k m (1 - c) has 1 - c = exp(-k * integral of m).
  const double mist = 60.0 + 0.5 * 0.2 / 100.0 * 60.0 * 60.0 - 0.2 / 100.0 * p.tube_s * 60.0;
  CHECK(s.flow_share() == Approx((1.0 + ramp) * std::exp(-0.001 * mist)).epsilon(2e-3));
}

TEST_CASE("An atomizer whose output falls with the vial's level falls exponentially") {
  AerosolParams p = steady();
  p.tube_s = 0.1;
  p.vial_s = 600.0;
  p.level_loss = 0.8;
  Source s(p, 1);
  s.step(300'000'000);
  // dl/dt = -(1 - loss (1 - l)) / vial: the output is exp(-loss t / vial), late by the tube's time.
  const double output = std::exp(-0.8 * (300.0 - p.tube_s) / 600.0);
  CHECK(s.flow_share() == Approx(output).epsilon(1e-3));
  CHECK(s.level() == Approx(1.0 - (1.0 - std::exp(-0.8 * 300.0 / 600.0)) / 0.8).epsilon(1e-3));
}

TEST_CASE("An empty vial stays empty, and gives what its loss leaves") {
  AerosolParams p = steady();
  p.vial_s = 100.0;
  p.level_loss = 0.5;
  Source s(p, 1);
  s.step(400'000'000);
  CHECK(s.level() == 0.0);
  CHECK(s.flow_share() == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("Mist that settles in the tube takes from the flow as told, and closes nothing of the nozzle") {
  AerosolParams p = steady();
  p.tube_per_h = 3.6;
  Source s(p, 1);
  s.step(200'000'000);
  CHECK(s.flow_share() == Approx(std::exp(-0.001 * 200.0)).epsilon(1e-5));
  CHECK(s.settles() == Approx(1.0 - std::exp(-0.001 * 200.0)).epsilon(1e-5));
  CHECK(s.open_share() == 1.0);
}

TEST_CASE("A blob gathers at the closed shutter and leaves with the first ink") {
  AerosolParams p = steady();
  p.blob_s = 0.02;
  Source s(p, 1);
  s.step(10'000'000);
  CHECK(s.gathered_mm3() == Approx(0.02 * p.flow_mm3_s).epsilon(0.01));
  s.switch_shutter(true, 10'000'000);
  Given sum;
  while (s.at_us() < 10'200'000) {
    const Given g = s.step(s.at_us() + 1000);
    sum.passed_mm3 += g.passed_mm3;
  }
  CHECK(sum.passed_mm3 == Approx(p.flow_mm3_s * (0.2 - 0.03 - p.tail_s + 0.02)).epsilon(0.01));
}

TEST_CASE("A track of constant accelerations is followed exactly, and its way found both ways") {
  // From rest, 1 s at (3, 4) mm/s^2, 1 s steady, 2 s to rest.
  const std::vector<TrackKnot> knots{
      {0, 0, 0, 0, 0}, {1, 1.5, 2, 3, 4}, {2, 4.5, 6, 3, 4}, {4, 7.5, 10, 0, 0}};
  const Track t(knots, 1'000'000);
  CHECK(t.end_us() == 5'000'000);
  CHECK(t.length_mm() == Approx(12.5).epsilon(1e-9));
  CHECK(t.position(1'500'000)[0] == Approx(0.375));
  CHECK(t.velocity(4'000'000)[1] == Approx(2.0));
  CHECK(t.travelled_mm(2'500'000) == Approx(5.0));
  for (const double s : {0.1, 2.5, 5.0, 9.0, 12.4})
    CHECK(t.travelled_mm(1'000'000 + std::llround(t.time_of_s(s) * 1e6)) == Approx(s).margin(1e-5));
}

namespace {

/// Ink that passes an open shutter in a second, under a supply of gas that has lasted for 20 s.
double passed_in_a_second(const AerosolParams& p, const GasSupply& gas, double* width_mm = nullptr) {
  Deposit d(kPlate, p, 1);
  const auto along = [](std::int64_t us) {
    return Deposit::Nozzle{0.5 + kSpeed_mm_s * (double(us) * 1e-6 - 20.0), 1.0, kSpeed_mm_s};
  };
  const auto supply = [&](std::int64_t) { return gas; };
  for (int n = 1; n <= 40; ++n) d.catch_up(n * 500'000, along, supply);
  d.switch_shutter(true, 20'000'000);
  d.catch_up(20'900'000, along, supply);
  const double passed = d.ledger().passed_mm3;
  if (width_mm) {
    const HeightMap h = d.surface().cell_means();
    double area = 0.0, second = 0.0;
    for (int j = 0; j < kPlate.ny; ++j) {
      const double n = kPlate.y_mm(j) - 1.0;
      area += h.at(100, j);
      second += n * n * h.at(100, j);
    }
    *width_mm = std::sqrt(second / area);
  }
  return passed;
}

}  // namespace

TEST_CASE("Ink goes with the atomizer's gas and the open section, and begins with the gas") {
  AerosolParams p = steady();
  p.gas = true;
  const double nominal = passed_in_a_second(p, {1.0, 2.0, 1.0});
  CHECK(nominal == Approx((0.9 - p.open_delay_s - p.tail_s) * p.flow_mm3_s).epsilon(0.001));
  CHECK(passed_in_a_second(p, {0.5, 2.0, 1.0}) == Approx(0.5 * nominal).epsilon(1e-9));
  CHECK(passed_in_a_second(p, {1.0, 2.0, 0.25}) == Approx(0.25 * nominal).epsilon(1e-9));
  CHECK(passed_in_a_second(p, {0.0, 2.0, 1.0}) == 0.0);

  Source source(p, 1);
  source.supply({1.0, 2.0, 1.0});
  source.step(2'000'000);
  CHECK(source.flow_share() == Approx(1.0 - std::exp(-1.0)).epsilon(0.001));  // mixed in tube_s = 2 s
  source.supply({0.0, 2.0, 1.0});
  source.step(4'000'000);
  CHECK(source.flow_share() == Approx((1.0 - std::exp(-1.0)) * std::exp(-1.0)).epsilon(0.001));
}

TEST_CASE("An atomizer's drift counts from its first gas") {
  AerosolParams p = steady();
  p.drift = 0.2;
  p.drift_s = 100.0;
  Source early(p, 1);
  p.gas = true;
  Source late(p, 1);
  early.step(200'000'000);
  late.step(200'000'000);
  CHECK(early.flow_share() == Approx(1.2).epsilon(0.001));
  CHECK(late.flow_share() == 0.0);
  late.supply({1.0, 2.0, 1.0});
  late.step(250'000'000);
  CHECK(late.flow_share() == Approx(1.1).epsilon(0.01));
}

TEST_CASE("A line's width goes with sheath by atomizer, and widest is a beam without a sheath") {
  AerosolParams p = steady();
  p.gas = true;
  p.spread = 0.0;
  double width[4];
  int n = 0;
  for (const double ratio : {0.0, 1.0, 2.0, 5.0}) {
    passed_in_a_second(p, {1.0, ratio, 1.0}, &width[n]);
    const double beam = 0.25 * p.nozzle_mm * std::sqrt(1.0 - std::sqrt(ratio / (1.0 + ratio)));
    CHECK(width[n] == Approx(std::sqrt(beam * beam + 0.02 * 0.02 / 12.0)).epsilon(0.02));
    ++n;
  }
  CHECK(width[0] > width[1]);
  CHECK(width[2] > width[3]);
}

TEST_CASE("A picture's blur is the convolution with a Gauss curve, beyond the edges with the pixels there") {
  constexpr int kWide = 23, kHigh = 17;
  constexpr double kBlur = 1.3;
  std::vector<float> picture(kWide * kHigh);
  for (std::size_t n = 0; n < picture.size(); ++n)
    picture[n] = float(random_uniform({1, Purpose::kTest, 0, 0, std::uint32_t(n)}));
  for (int x = 0; x < kWide; ++x) picture[std::size_t(3 * kWide + x)] = 0.25f;
  std::vector<float> blurred = picture;
  plant::blur_picture(blurred, kWide, kHigh, kBlur);
  double worst = 0.0;
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) {
      double sum = 0.0, weights = 0.0;
      for (int j = -6; j <= 6; ++j)
        for (int i = -6; i <= 6; ++i) {
          const double weight = std::exp(-0.5 * (i * i + j * j) / (kBlur * kBlur));
          sum += weight * double(picture[std::size_t(std::clamp(y + j, 0, kHigh - 1) * kWide +
                                                     std::clamp(x + i, 0, kWide - 1))]);
          weights += weight;
        }
      worst = std::max(worst, std::abs(double(blurred[std::size_t(y * kWide + x)]) - sum / weights));
    }
  CHECK(worst < 1e-6);
  std::vector<float> flat(kWide * kHigh, 0.3f);
  plant::blur_picture(flat, kWide, kHigh, kBlur);
  CHECK(std::ranges::all_of(flat, [](float v) { return v == 0.3f; }));
}
