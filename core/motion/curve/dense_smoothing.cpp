#include "core/motion/curve/dense_smoothing.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr std::size_t kLeastChords = 8;
constexpr double kHeld = 1e9;  ///< weight of a point that stays, in units of 1 + lambda
constexpr double kLeastLog = -3.0, kMostLog = 7.0;
constexpr int kHalvings = 14;

/// The run of dense chords that starts at piece k: one past its last piece.
std::size_t run_end(std::span<const CurvePiece> pieces, std::size_t k, double longest_mm) {
  while (k < pieces.size() && pieces[k].chord && pieces[k].length_mm < longest_mm) ++k;
  return k;
}

/// (W + lambda D^T D) q = W p by L D L^T; D = third differences, W = 1 but at the held ends.
void whittaker(std::span<const Point2> p, double lambda, std::size_t held_first, std::size_t held_last,
               SmoothingWork& work) {
  static constexpr double third[4] = {-1.0, 3.0, -3.0, 1.0};
  const std::size_t n = p.size();
  for (auto& band : work.band) band.assign(n + 3, 0.0);
  for (std::size_t i = 0; i + 3 < n; ++i)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a; b < 4; ++b) work.band[b - a][i + a] += lambda * third[a] * third[b];
  work.x.resize(n);
  work.y.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double w = i < held_first || i + held_last >= n ? kHeld * (1.0 + lambda) : 1.0;
    work.band[0][i] += w;
    work.x[i] = w * p[i].x_mm;
    work.y[i] = w * p[i].y_mm;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double over = 1.0 / work.band[0][i];
    double row[4];
    for (std::size_t k = 1; k < 4; ++k) row[k] = work.band[k][i];
    for (std::size_t k = 1; k < 4 && i + k < n; ++k) {
      const double factor = row[k] * over;
      for (std::size_t m = k; m < 4 && i + m < n; ++m) work.band[m - k][i + k] -= factor * row[m];
      work.x[i + k] -= factor * work.x[i];
      work.y[i + k] -= factor * work.y[i];
    }
    work.x[i] *= over;
    work.y[i] *= over;
    for (std::size_t k = 1; k < 4; ++k) work.band[k][i] = row[k] * over;
  }
  for (std::size_t i = n; i-- > 0;)
    for (std::size_t k = 1; k < 4 && i + k < n; ++k) {
      work.x[i] -= work.band[k][i] * work.x[i + k];
      work.y[i] -= work.band[k][i] * work.y[i + k];
    }
}

double farthest(std::span<const Point2> p, const SmoothingWork& work) {
  double most = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double dx = work.x[i] - p[i].x_mm, dy = work.y[i] - p[i].y_mm;
    most = std::max(most, dx * dx + dy * dy);
  }
  return std::sqrt(most);
}

}  // namespace

bool has_dense_run(std::span<const CurvePiece> pieces, double longest_mm) {
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const std::size_t end = run_end(pieces, k, longest_mm);
    if (end - k >= kLeastChords) return true;
    k = end;
  }
  return false;
}

void smooth_dense(std::span<const Point2> points, std::span<const CurvePiece> pieces, double longest_mm,
                  double tolerance_mm, SmoothingWork& work, std::vector<Point2>& out) {
  out.assign(points.begin(), points.end());
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const std::size_t end = run_end(pieces, k, longest_mm);
    if (end - k >= kLeastChords) {
      const std::size_t from = pieces[k].first, to = pieces[end - 1].last;
      const auto run = points.subspan(from, to - from + 1);
      const std::size_t held_first = from == 0 ? 1 : 2, held_last = to + 1 == points.size() ? 1 : 2;
      double low = kLeastLog, high = kMostLog;
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        whittaker(run, std::pow(10.0, middle), held_first, held_last, work);
        (farthest(run, work) <= tolerance_mm ? low : high) = middle;
      }
      whittaker(run, std::pow(10.0, low), held_first, held_last, work);
      if (farthest(run, work) <= tolerance_mm)
        for (std::size_t i = held_first; i + held_last < run.size(); ++i)
          out[from + i] = {work.x[i], work.y[i]};
    }
    k = end;
  }
}

}  // namespace firn::motion
