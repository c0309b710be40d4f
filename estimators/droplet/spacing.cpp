#include "estimators/droplet/spacing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace firn::droplet {
namespace {

SpacingResult update_fit(double gamma, const std::vector<const SquareRise*>& squares, double noise_std_mm) {
  SpacingResult r;
  r.gamma = gamma;
  int largest = 0;
  for (const SquareRise* s : squares) largest = std::max(largest, s->n);
  double within = 0.0, spread = 0.0;
  std::vector<double> means;
  for (int n = 2; n <= largest; ++n) {
    double mean = 0.0, inner = 0.0;
    int count = 0;
    for (const SquareRise* s : squares) {
      if (s->n != n) continue;
      mean += s->mean_mm;
      inner += s->square_mm2 - s->mean_mm * s->mean_mm;
      ++count;
    }
    r.repeats.push_back(count);
    r.mean_mm.push_back(count ? mean / count : 0.0);
    if (!count) continue;
    means.push_back(mean / count);
    within += inner / count;
  }
  if (means.size() < 2)
    throw std::invalid_argument("spacing: squares of at least two sizes (2 x 2 and more) are needed");
  for (const double m : means) r.height_mm += m / double(means.size());
  if (!(r.height_mm > 0.0)) throw std::invalid_argument("spacing: the squares have not risen");
  for (const double m : means) spread += (m - r.height_mm) * (m - r.height_mm) / double(means.size() - 1);
  within = std::max(0.0, within / double(means.size()) - noise_std_mm * noise_std_mm);
  r.between_sizes = std::sqrt(spread) / r.height_mm;
  r.within = std::sqrt(within) / r.height_mm;
  r.inconsistency = std::sqrt(r.between_sizes * r.between_sizes + r.within * r.within);
  return r;
}

// Vertex of the parabola through three points; the middle one when it does not open upwards.
double vertex(const double (&x)[3], const double (&y)[3]) {
  const double d1 = (y[1] - y[0]) / (x[1] - x[0]), d2 = (y[2] - y[1]) / (x[2] - x[1]);
  const double curve = (d2 - d1) / (x[2] - x[0]);
  if (!(curve > 0.0)) return x[1];
  return std::clamp(0.5 * (x[0] + x[1]) - 0.5 * d1 / curve, x[0], x[2]);
}

}  // namespace

std::vector<SquareRise> square_rises(const HeightMap& before, const HeightMap& after,
                                     const std::vector<Use>& use, const std::vector<Square>& squares) {
  std::vector<SquareRise> out;
  for (const Square& s : squares) {
    const int side = (s.n - 1) * s.step + 1;
    SquareRise r;
    r.n = s.n;
    double cells = 0.0, under = 0.0, unders = 0.0, between = 0.0, betweens = 0.0;
    bool whole = true;
    for (int y = 0; y < side && whole; ++y)
      for (int x = 0; x < side; ++x) {
        if (!before.spec.contains(s.i + x, s.j + y) ||
            use[before.spec.index(s.i + x, s.j + y)] != Use::kLearn) {
          whole = false;
          break;
        }
        const double z = after.at(s.i + x, s.j + y) - before.at(s.i + x, s.j + y);
        cells += 1.0;
        r.mean_mm += z;
        r.square_mm2 += z * z;
        if (x % s.step == 0 && y % s.step == 0) {
          under += z;
          unders += 1.0;
        }
        if (2 * (x % s.step) == s.step && 2 * (y % s.step) == s.step) {
          between += z;
          betweens += 1.0;
        }
      }
    if (!whole) continue;
    r.mean_mm /= cells;
    r.square_mm2 /= cells;
    if (betweens > 0.0) r.ripple_mm = under / unders - between / betweens;
    out.push_back(r);
  }
  return out;
}

SpacingResult evaluate_spacing(double gamma, const std::vector<SquareRise>& squares, double noise_std_mm) {
  std::vector<const SquareRise*> all;
  for (const SquareRise& s : squares)
    if (s.n >= 2) all.push_back(&s);
  SpacingResult r = update_fit(gamma, all, noise_std_mm);
  // Jackknife over repeats: the k-th repeat of every size is left out together.
  const int repeats = *std::min_element(r.repeats.begin(), r.repeats.end());
  if (repeats < 2) return r;
  double mean = 0.0;
  std::vector<double> left(std::size_t(repeats), 0.0);
  for (int k = 0; k < repeats; ++k) {
    std::vector<const SquareRise*> some;
    std::vector<int> seen(64 + 1, 0);
    for (const SquareRise* s : all)
      if (seen[std::size_t(std::min(s->n, 64))]++ != k) some.push_back(s);
    left[std::size_t(k)] = update_fit(gamma, some, noise_std_mm).inconsistency;
    mean += left[std::size_t(k)] / repeats;
  }
  double squares_sum = 0.0;
  for (const double v : left) squares_sum += (v - mean) * (v - mean);
  r.std_error = std::sqrt(squares_sum * (repeats - 1) / repeats);
  return r;
}

SpacingChoice choose_spacing(const std::vector<SpacingResult>& results) {
  if (results.size() < 3)
    throw std::invalid_argument("spacing: runs at three spacings or more are needed, here are " +
                                std::to_string(results.size()));
  for (std::size_t n = 1; n < results.size(); ++n)
    if (!(results[n].gamma > results[n - 1].gamma))
      throw std::invalid_argument("spacing: two runs have the same spacing");
  SpacingChoice c;
  for (std::size_t n = 1; n < results.size(); ++n)
    if (results[n].inconsistency < results[c.best].inconsistency) c.best = n;
  c.inside = c.best > 0 && c.best + 1 < results.size();
  c.gamma = results[c.best].gamma;
  if (!c.inside) return c;
  double x[3], y[3], variance = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = results[c.best - 1 + k].gamma;
    y[k] = results[c.best - 1 + k].inconsistency;
  }
  c.gamma = vertex(x, y);
  for (std::size_t k = 0; k < 3; ++k) {
    double moved[3] = {y[0], y[1], y[2]};
    moved[k] += results[c.best - 1 + k].std_error;
    const double by = vertex(x, moved) - c.gamma;
    variance += by * by;
  }
  c.std_error = std::sqrt(variance);
  return c;
}

}  // namespace firn::droplet
