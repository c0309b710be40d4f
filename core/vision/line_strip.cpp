#include "core/vision/line_strip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/statistics/median.h"
#include "core/vision/least_squares.h"

namespace firn::vision {
namespace {

// Chosen on rendered pictures (tests/bench/line_pictures.cpp, seeds below 50,000).
constexpr double kBilinear = 1.0 / 6;  // mean variance of bilinear interpolation [px^2]
// Ground: a quadric through the far columns, a plane over a flat field, with Tukey's biweight.
constexpr double kFarShare = 0.88;  // of the window: the ground alone
constexpr std::size_t kMinFarSamples = 60;
constexpr int kGroundRounds = 5;
constexpr double kGroundStds = 4.0;  // where a sample's weight reaches 0, but not below
constexpr double kGroundShare = 0.004, kGround_levels = 0.5;  // … a share of the level and half a grey level
constexpr double kGroundRidge = 1e-3;  // of terms that are off, and of strips that are too short
constexpr double kMinGroundShare =
    0.05;  // of the middle's level: bounds contrasts where the quadric falls to 0
constexpr double kGroundSamples = 2.5;  // std of the ground's mean over that of independent samples
constexpr double kDeblurStep2 = 0.25;   // 1 / (2 px)^2: the bend is taken over two columns to either side

double sampled(const Frame& f, const Frame* flat, double x, double y) {
  if (!(x >= 0.0 && y >= 0.0 && x <= f.width - 1.0 && y <= f.height - 1.0)) return kUnread;
  const int i = std::min(int(x), f.width - 2), j = std::min(int(y), f.height - 2);
  const double u = x - i, v = y - j;
  const auto level = [&](int a, int b) {
    const double p = double(f.at(a, b));
    return flat ? p * double(flat->white) / std::max(1.0, double(flat->at(a, b))) : p;
  };
  return (1 - v) * ((1 - u) * level(i, j) + u * level(i + 1, j)) +
         v * ((1 - u) * level(i, j + 1) + u * level(i + 1, j + 1));
}

}  // namespace

Strip sample_strip(const Frame& f, const Frame* flat, const LineView& view) {
  Strip s;
  const Point d = view.direction, left{d.y, -d.x};
  const bool aligned = std::min(std::abs(d.x), std::abs(d.y)) < 1e-9;
  const double half = std::floor(view.window_px);
  s.columns = 2 * int(half) + 1;
  s.rows = std::max(1, int(std::floor(view.length_px)));
  s.first_across_px = -half;
  s.first_along_px = -0.5 * (s.rows - 1);
  if (aligned) {
    const auto snap = [](double along_axis) { return std::round(along_axis) - along_axis; };
    const double across = view.middle.x * left.x + view.middle.y * left.y,
                 along = view.middle.x * d.x + view.middle.y * d.y;
    s.first_across_px += snap(across + s.first_across_px);
    s.first_along_px += snap(along + s.first_along_px);
  } else {
    s.interpolation = kBilinear;
  }
  s.value.reserve(std::size_t(s.rows) * std::size_t(s.columns));
  std::size_t white = 0;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c) {
      const double t = s.first_along_px + a, o = s.first_across_px + c;
      const double x = view.middle.x + t * d.x + o * left.x, y = view.middle.y + t * d.y + o * left.y;
      s.value.push_back(sampled(f, flat, x, y));
      if (!std::isnan(s.value.back())) white += f.at(int(x + 0.5), int(y + 0.5)) >= f.white;
    }
  s.saturated = double(white) / double(s.value.size());
  return s;
}

std::optional<double> to_contrast(Strip& s, bool flat) {
  const double window = 0.5 * (s.columns - 1), length = std::max(1.0, 0.5 * s.rows);
  using Quadric = SmallLeastSquares<6>::Row;
  const auto row_of = [&](int a, int c) -> Quadric {
    const double x = (a - 0.5 * (s.rows - 1)) / length, y = (c - window) / window;
    if (flat) return {1, x, y, 0, 0, 0};
    return {1, x, y, x * x, x * y, y * y};
  };
  const auto value_of = [](const Quadric& q, const Quadric& row) {
    double v = 0.0;
    for (int k = 0; k < 6; ++k) v += q[k] * row[k];
    return v;
  };
  std::vector<std::pair<int, int>> far;
  std::vector<double> levels;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c)
      if (std::abs(c - window) >= kFarShare * window && !std::isnan(s.at(a, c))) {
        far.emplace_back(a, c);
        levels.push_back(s.at(a, c));
      }
  if (far.size() < kMinFarSamples) return std::nullopt;
  Quadric ground{statistics::median(levels)};
  double spread = 0.0;
  for (int round = 0; round < kGroundRounds; ++round) {
    std::vector<double> off;
    for (const auto& [a, c] : far) off.push_back(std::abs(s.at(a, c) - value_of(ground, row_of(a, c))));
    spread = statistics::kMadToStd * statistics::median(off);
    const double limit = std::max(kGroundStds * spread, kGroundShare * std::abs(ground[0]) + kGround_levels);
    SmallLeastSquares<6> sums;
    for (const auto& [a, c] : far) {
      const Quadric row = row_of(a, c);
      const double q = (s.at(a, c) - value_of(ground, row)) / limit;
      if (q * q < 1.0) sums.add(row, s.at(a, c), (1 - q * q) * (1 - q * q));
    }
    for (int k = 0; k < 6; ++k) {
      Quadric one{};
      one[k] = 1.0;
      sums.add(one, 0.0, k == 0 ? 0.0 : kGroundRidge);
    }
    if (Quadric next{}; sums.solve(next)) ground = next;
  }
  if (!(ground[0] > 0.0)) return std::nullopt;
  for (int a = 0; a < s.rows; ++a)
    for (int c = 0; c < s.columns; ++c)
      if (double& v = s.at(a, c); !std::isnan(v))
        v = 1.0 - v / std::max(kMinGroundShare * ground[0], value_of(ground, row_of(a, c)));
  return spread / ground[0] * kGroundSamples / std::sqrt(double(far.size()));
}

double pixel_noise(const Strip& s) {
  std::vector<double> d;
  for (int a = 0; a + 2 < s.rows; ++a)
    for (int c = a % 3; c < s.columns; c += 3)
      if (const double v = s.at(a, c) - s.at(a + 2, c); !std::isnan(v)) d.push_back(std::abs(v));
  return d.empty() ? 0.0 : statistics::kMadToStd * statistics::median(d) / std::sqrt(2.0);
}

std::vector<double> mean_profile(const Strip& s, const std::vector<int>& rows) {
  std::vector<double> sum(std::size_t(s.columns)), out(std::size_t(s.columns), kUnread);
  std::vector<int> n(std::size_t(s.columns));
  for (const int a : rows)
    for (int c = 0; c < s.columns; ++c)
      if (const double v = s.at(a, c); !std::isnan(v)) {
        sum[std::size_t(c)] += v;
        ++n[std::size_t(c)];
      }
  for (std::size_t c = 0; c < sum.size(); ++c)
    if (n[c] > 0) out[c] = sum[c] / n[c];
  return out;
}

std::vector<double> deblurred(const std::vector<double>& p, double variance) {
  std::vector<double> out = p;
  for (std::size_t c = 2; c + 2 < p.size(); ++c) {
    const double bend = kDeblurStep2 * (p[c + 2] - 2 * p[c] + p[c - 2]);
    if (!std::isnan(bend)) out[c] -= 0.5 * variance * bend;
  }
  return out;
}

}  // namespace firn::vision
