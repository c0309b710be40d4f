#include "core/vision/rim.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/vision/least_squares.h"

namespace firn::vision {
namespace {

constexpr double kHollow = 0.92;    // of the rim's peak: a middle that is darker is none
constexpr double kPlateau = 3.5;    // width of a rim over its blur from which it reaches its plateau
constexpr double kLevelStd = 0.2;   // of the liquid's opacity from 1
constexpr double kResidual = 0.03;  // of the peak: a profile that is farther from the model is no rim
constexpr double kLeastBlur_px = 0.8;
constexpr int kRounds = 24;

// exp(-x) for x >= 0 by its series and squares: the same bytes on every machine.
double decayed(double x) {
  constexpr int kHalvings = 10;
  const double y = -x / (1 << kHalvings);
  double e = 1 + y * (1 + y / 2 * (1 + y / 3 * (1 + y / 4)));
  for (int n = 0; n < kHalvings; ++n) e *= e;
  return e;
}

double density(double z) {
  constexpr double kOverRootTwoPi = 0.3989422804014327;
  return std::abs(z) > 8.0 ? 0.0 : kOverRootTwoPi * decayed(0.5 * z * z);
}

// [Abramowitz and Stegun, 26.2.17], to 7.5e-8.
double distribution(double z) {
  const double t = 1.0 / (1.0 + 0.2316419 * std::abs(z));
  const double tail =
      density(z) * t *
      (0.319381530 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
  return z >= 0.0 ? 1.0 - tail : tail;
}

using Parameters = std::array<double, 5>;  // A, B, edge, width, blur

double cost_of(const Parameters& p, std::span<const double> opacity, double first, double pitch) {
  double square = 0.0;
  for (std::size_t k = 0; k < opacity.size(); ++k) {
    const double d = first + pitch * double(k);
    const double off =
        opacity[k] - p[0] * distribution((p[2] - d) / p[4]) + p[1] * distribution((p[2] - p[3] - d) / p[4]);
    square += off * off;
  }
  const double level = (p[0] - 1.0) / kLevelStd * kResidual;
  return square + level * level;
}

}  // namespace

RimFit fit_rim(std::span<const double> opacity, double first_px, double pitch_px, double blur_px) {
  RimFit fit;
  if (opacity.size() < 12) return fit;
  const auto peak = std::ranges::max_element(opacity);
  if (!(*std::min_element(opacity.begin(), peak + 1) < kHollow * *peak) || *peak <= 0.0) return fit;
  const double to_peak = -(first_px + pitch_px * double(peak - opacity.begin()));
  Parameters p{std::max(1.0, *peak), 0.8, 0.0, std::max(2.0 * to_peak, pitch_px),
               std::max(kLeastBlur_px, blur_px)};
  double cost = cost_of(p, opacity, first_px, pitch_px), damping = 1e-3;
  for (int round = 0; round < kRounds; ++round) {
    SmallLeastSquares<5> sums;
    for (std::size_t k = 0; k < opacity.size(); ++k) {
      const double d = first_px + pitch_px * double(k);
      const double u = (p[2] - d) / p[4], v = (p[2] - p[3] - d) / p[4];
      const double fu = distribution(u), fv = distribution(v), gu = p[0] * density(u) / p[4],
                   gv = p[1] * density(v) / p[4];
      sums.add({fu, -fv, gu - gv, gv, -u * gu + v * gv}, opacity[k] - p[0] * fu + p[1] * fv, 1.0);
    }
    const double level = kResidual / kLevelStd;
    sums.add({level, 0, 0, 0, 0}, level * (1.0 - p[0]), 1.0);
    for (std::size_t n = 0; n < 5; ++n) {
      std::array<double, 5> row{};
      row[n] = std::sqrt(damping);
      sums.add(row, 0.0, 1.0);
    }
    Parameters step{};
    if (!sums.solve(step)) return fit;
    Parameters next = p;
    for (std::size_t n = 0; n < 5; ++n) next[n] += step[n];
    next[1] = std::max(0.0, next[1]);
    next[3] = std::max(0.5 * pitch_px, next[3]);
    next[4] = std::max(0.5 * kLeastBlur_px, next[4]);
    const double now = cost_of(next, opacity, first_px, pitch_px);
    if (now < cost) {
      p = next;
      cost = now;
      damping = std::max(1e-9, 0.3 * damping);
    } else {
      damping *= 6.0;
    }
  }
  const double rms = std::sqrt(cost / double(opacity.size()));
  fit = {false, p[2], p[4], p[3], p[0]};
  fit.found = rms < kResidual * *peak && p[4] > kLeastBlur_px && p[3] < kPlateau * p[4] && p[0] > 0.6 &&
              p[0] < 1.8 && std::abs(p[2]) < 2.0 * p[4];
  return fit;
}

}  // namespace firn::vision
