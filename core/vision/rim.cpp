#include "core/vision/rim.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/vision/least_squares.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on drawn profiles and discs
// (tests/core/vision/soft_pictures_test.cpp).
constexpr std::size_t kMinProfile = 12;  // samples of a profile that is fitted
constexpr double kMaxMiddle = 0.92;  // opacity of the middle over the rim's peak: a darker one is no middle
constexpr double kMaxThinRim = 3.5;  // width of a rim over its blur from which it reaches its plateau
constexpr double kLevelStd = 0.2;    // of the liquid's opacity from 1
constexpr double kMaxResidualRim = 0.03;  // of the peak: a profile that is farther from the model is no rim
constexpr double kMinBlur_px = 0.8;       // of a first guess; half of it in the fit
constexpr double kMaxResidualClipped =
    0.02;  // of the plateau: a profile that is farther from the model is no edge
constexpr double kMinRimLevel = 0.6, kMaxRimLevel = 1.8;  // opacity of the liquid in a fit that counts
constexpr double kMaxRimShift = 2.0,
                 kMaxClippedShift = 3.0;       // blurs: distance of an edge from its halfway point
constexpr std::size_t kMinClippedProfile = 8;  // samples from the peak on
constexpr double kMaxBlurRatio = 2.0;          // of a clipped edge's blur over its first guess
// Levenberg and Marquardt's damping of the normal equations' diagonal.
constexpr int kRounds = 24;
constexpr double kFirstDamping = 1e-3, kMinDamping = 1e-9, kLessDamping = 0.3, kMoreDamping = 6.0;

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
  const double level = (p[0] - 1.0) / kLevelStd * kMaxResidualRim;
  return square + level * level;
}

struct EdgeProfile {
  std::span<const double> opacity;
  double first_px, pitch_px;
};
using EdgeParameters = std::array<double, 4>;  // A, c, edge, blur

// Between pixels the opacity is bilinear: a triangle of +-1 px that comes after the sensor has cut the light
// off.
constexpr std::array<double, 5> kPlaces_px{-0.7071, -0.3536, 0.0, 0.3536, 0.7071};
constexpr std::array<double, 5> kWeights{1.0 / 9, 2.0 / 9, 3.0 / 9, 2.0 / 9, 1.0 / 9};
constexpr double kInterpolated_px2 = 1.0 / 6;  // variance of these

double clipped_at(const EdgeParameters& p, double d) {
  double sum = 0.0;
  for (std::size_t n = 0; n < kPlaces_px.size(); ++n)
    sum += kWeights[n] * std::max(0.0, (1.0 + p[1]) * distribution((p[2] - d - kPlaces_px[n]) / p[3]) - p[1]);
  return p[0] * sum;
}

double cost_of(const EdgeParameters& p, const EdgeProfile& profile) {
  double square = 0.0;
  for (std::size_t k = 0; k < profile.opacity.size(); ++k) {
    const double off = profile.opacity[k] - clipped_at(p, profile.first_px + profile.pitch_px * double(k));
    square += off * off;
  }
  return square;
}

SmallLeastSquares<4> equations_of(const EdgeParameters& p, const EdgeProfile& profile) {
  SmallLeastSquares<4> sums;
  for (std::size_t k = 0; k < profile.opacity.size(); ++k) {
    const double d = profile.first_px + profile.pitch_px * double(k);
    double model = 0.0;
    EdgeParameters row{};
    for (std::size_t n = 0; n < kPlaces_px.size(); ++n) {
      const double u = (p[2] - d - kPlaces_px[n]) / p[3], share = distribution(u),
                   opacity = (1.0 + p[1]) * share - p[1], slope = p[0] * (1.0 + p[1]) * density(u) / p[3];
      if (opacity <= 0.0) continue;
      model += kWeights[n] * p[0] * opacity;
      row[0] += kWeights[n] * opacity;
      row[1] += kWeights[n] * p[0] * (share - 1.0);
      row[2] += kWeights[n] * slope;
      row[3] -= kWeights[n] * slope * u;
    }
    if (model > 0.0) sums.add(row, profile.opacity[k] - model, 1.0);
  }
  return sums;
}

constexpr double kMaxExcess = 4.0;  // light over the white level, less 1
// Standard deviation of the edge, as shares of its distance from the halfway point: measured on drawn discs
// of 25 to 110 px before light of 1.02 to 2.2 times the white level.
constexpr double kShiftStd = 0.2, kShiftStdPerExcess = 0.6;

// Damped Gauss-Newton steps from one guess. @returns the cost
double fit_from(EdgeParameters& p, const EdgeProfile& profile) {
  double cost = cost_of(p, profile), damping = kFirstDamping;
  for (int round = 0; round < kRounds; ++round) {
    SmallLeastSquares<4> sums = equations_of(p, profile);
    for (std::size_t n = 0; n < p.size(); ++n) {
      EdgeParameters row{};
      row[n] = std::sqrt(damping);
      sums.add(row, 0.0, 1.0);
    }
    EdgeParameters step{};
    if (!sums.solve(step)) break;
    EdgeParameters next = p;
    for (std::size_t n = 0; n < p.size(); ++n) next[n] += step[n];
    next[0] = std::max(0.1, next[0]);
    next[1] = std::clamp(next[1], 0.0, 2.0 * kMaxExcess);
    next[3] = std::max(0.5 * kMinBlur_px, next[3]);
    if (const double now = cost_of(next, profile); now < cost) {
      p = next;
      cost = now;
      damping = std::max(kMinDamping, kLessDamping * damping);
    } else {
      damping *= kMoreDamping;
    }
  }
  return cost;
}

}  // namespace

ClippedEdge fit_clipped_edge(std::span<const double> opacity, double first_px, double pitch_px,
                             double blur_px) {
  ClippedEdge fit;
  if (opacity.size() < kMinProfile) return fit;
  const auto peak = std::ranges::max_element(opacity);
  const std::size_t from = std::size_t(peak - opacity.begin());
  if (opacity.size() - from < kMinClippedProfile || *peak <= 0.0) return fit;
  const EdgeProfile profile{opacity.subspan(from), first_px + pitch_px * double(from), pitch_px};
  EdgeParameters best{};
  double min_cost = -1.0;
  for (const double excess : {0.1, 0.5, 1.5}) {
    EdgeParameters p{*peak, excess, 0.0, std::max(kMinBlur_px, blur_px) * (1.0 + excess)};
    if (const double cost = fit_from(p, profile); min_cost < 0.0 || cost < min_cost) {
      min_cost = cost;
      best = p;
    }
  }
  const double rms = std::sqrt(min_cost / double(profile.opacity.size()));
  fit = {false, best[2], std::abs(best[2]) * (kShiftStd + kShiftStdPerExcess * best[1]),
         std::sqrt(best[3] * best[3] + kInterpolated_px2)};
  fit.found = rms < kMaxResidualClipped * best[0] && best[1] < kMaxExcess &&
              std::abs(best[2]) < kMaxClippedShift * best[3] &&
              best[3] < kMaxBlurRatio * (std::max(kMinBlur_px, blur_px) * (1.0 + best[1]));
  return fit;
}

RimFit fit_rim(std::span<const double> opacity, double first_px, double pitch_px, double blur_px) {
  RimFit fit;
  if (opacity.size() < kMinProfile) return fit;
  const auto peak = std::ranges::max_element(opacity);
  if (!(*std::min_element(opacity.begin(), peak + 1) < kMaxMiddle * *peak) || *peak <= 0.0) return fit;
  const double to_peak = -(first_px + pitch_px * double(peak - opacity.begin()));
  Parameters p{std::max(1.0, *peak), 0.8, 0.0, std::max(2.0 * to_peak, pitch_px),
               std::max(kMinBlur_px, blur_px)};
  double cost = cost_of(p, opacity, first_px, pitch_px), damping = kFirstDamping;
  for (int round = 0; round < kRounds; ++round) {
    SmallLeastSquares<5> sums;
    for (std::size_t k = 0; k < opacity.size(); ++k) {
      const double d = first_px + pitch_px * double(k);
      const double u = (p[2] - d) / p[4], v = (p[2] - p[3] - d) / p[4];
      const double fu = distribution(u), fv = distribution(v), gu = p[0] * density(u) / p[4],
                   gv = p[1] * density(v) / p[4];
      sums.add({fu, -fv, gu - gv, gv, -u * gu + v * gv}, opacity[k] - p[0] * fu + p[1] * fv, 1.0);
    }
    const double level = kMaxResidualRim / kLevelStd;
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
    next[4] = std::max(0.5 * kMinBlur_px, next[4]);
    const double now = cost_of(next, opacity, first_px, pitch_px);
    if (now < cost) {
      p = next;
      cost = now;
      damping = std::max(kMinDamping, kLessDamping * damping);
    } else {
      damping *= kMoreDamping;
    }
  }
  const double rms = std::sqrt(cost / double(opacity.size()));
  fit = {false, p[2], p[4], p[3], p[0]};
  fit.found = rms < kMaxResidualRim * *peak && p[4] > kMinBlur_px && p[3] < kMaxThinRim * p[4] &&
              p[0] > kMinRimLevel && p[0] < kMaxRimLevel && std::abs(p[2]) < kMaxRimShift * p[4];
  return fit;
}

}  // namespace firn::vision
