#include "estimators/surface/robust_smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/statistics/median.h"
#include "estimators/surface/cosine_transform.h"

namespace firn::surface {
namespace {

constexpr double kBisquare = 4.685;
// Candidates of s: kSmallest * kStep^n. Bounds of smoothn for two dimensions (leverages 0.99 and 1e-6).
constexpr double kSmallest = 8.4e-4;
constexpr double kStep = 1.189207115002721;  // 2^(1/4)
constexpr int kCandidates = 176;

// Leverage of a datum in two dimensions [Garcia 2010, Eq. (17)].
double leverage(double s) {
  const double a = std::sqrt(1.0 + 16.0 * s);
  return (1.0 + a) / (2.0 * a * a);
}

// Nearest known value by a breadth-first walk over the eight neighbours, rows before columns.
void fill_nearest(const GridSpec& g, std::vector<double>& y, const std::vector<double>& weight) {
  std::vector<std::size_t> front, next;
  std::vector<std::uint8_t> known(y.size());
  for (std::size_t c = 0; c < y.size(); ++c)
    if (weight[c] > 0.0) {
      front.push_back(c);
      known[c] = 1;
    }
  for (; !front.empty(); front.swap(next), next.clear())
    for (const std::size_t c : front) {
      const int i = int(c) % g.nx, j = int(c) / g.nx;
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          if (!g.contains(i + di, j + dj)) continue;
          const std::size_t n = g.index(i + di, j + dj);
          if (known[n]) continue;
          y[n] = y[c];
          known[n] = 1;
          next.push_back(n);
        }
    }
}

}  // namespace

struct RobustSmoother::Work {
  explicit Work(const GridSpec& grid)
      : g(grid),
        dct(grid.nx, grid.ny),
        lambda2(grid.size()),
        y(grid.size()),
        z(grid.size()),
        before(grid.size()),
        mixed(grid.size()),
        spectrum(grid.size()),
        weight(grid.size()),
        given(grid.size()) {
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        const double lambda = 2.0 * (cos_pi(i, g.nx) - 1.0) + 2.0 * (cos_pi(j, g.ny) - 1.0);
        lambda2[g.index(i, j)] = lambda * lambda;
      }
    candidates.push_back(kSmallest);
    while (int(candidates.size()) < kCandidates) candidates.push_back(candidates.back() * kStep);
  }

  // Generalised cross-validation score of s for the present `spectrum`. With nearly all weights 1 the
  // residual is read from the spectrum, else from the transformed-back surface, as smoothn does.
  double score(double s) {
    double trace = 0.0, residual = 0.0;
    for (std::size_t c = 0; c < lambda2.size(); ++c) {
      const double gamma = 1.0 / (1.0 + s * lambda2[c]);
      trace += gamma;
      if (nearly_full) {
        const double r = (gamma - 1.0) * spectrum[c];
        residual += r * r;
      } else {
        mixed[c] = gamma * spectrum[c];
      }
    }
    if (!nearly_full) {
      dct.inverse(mixed, trial);
      for (std::size_t c = 0; c < y.size(); ++c)
        residual += weight[c] * (y[c] - trial[c]) * (y[c] - trial[c]);
    }
    const double free = 1.0 - trace / double(y.size());
    return residual / known / (free * free);
  }

  // Candidate of least score. The first search looks at every 16th, later ones start at the last answer; both
  // then go downhill with halving steps.
  void search() {
    int step = 4;
    least = std::numeric_limits<double>::infinity();
    if (chosen < 0) {
      for (int n = 8; n < kCandidates; n += 16) try_candidate(n);
      step = 8;
    } else {
      try_candidate(chosen);
    }
    while (step > 0) {
      const int from = chosen;
      for (const int n : {from - step, from + step})
        if (n >= 0 && n < kCandidates) try_candidate(n);
      if (chosen == from) step /= 2;
    }
  }
  void try_candidate(int n) {
    if (const double v = score(candidates[std::size_t(n)]); v < least) {
      least = v;
      chosen = n;
    }
  }

  // One pass of the fixed point. Returns the root mean square move over cells with weight.
  double iterate(double s, double relaxation) {
    for (std::size_t c = 0; c < y.size(); ++c) spectrum[c] *= 1.0 / (1.0 + s * lambda2[c]);
    dct.inverse(spectrum, mixed);
    double move = 0.0, sum = 0.0;
    for (std::size_t c = 0; c < y.size(); ++c) {
      const double next = relaxation * mixed[c] + (1.0 - relaxation) * z[c];
      move += given[c] * (next - z[c]) * (next - z[c]);
      sum += given[c];
      z[c] = next;
    }
    return std::sqrt(move / sum);
  }

  void transform_data() {
    for (std::size_t c = 0; c < y.size(); ++c) before[c] = weight[c] * (y[c] - z[c]) + z[c];
    dct.forward(before, spectrum);
  }

  // Median deviation of the residuals of known cells, as a standard deviation.
  double residual_std() {
    scratch.clear();
    for (std::size_t c = 0; c < y.size(); ++c)
      if (given[c] > 0.0) scratch.push_back(y[c] - z[c]);
    const double middle = statistics::median(scratch);
    for (double& r : scratch) r = std::abs(r - middle);
    return statistics::kMadToStd * statistics::median(scratch);
  }

  void reweight(double s) {
    const double spread = residual_std() * std::sqrt(1.0 - leverage(s));
    for (std::size_t c = 0; c < y.size(); ++c) {
      const double u = spread > 0.0 ? std::abs(y[c] - z[c]) / (kBisquare * spread) : 0.0;
      const double b = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
      weight[c] = given[c] * b;
    }
  }

  GridSpec g;
  CosineTransform dct;
  std::vector<double> lambda2, y, z, before, mixed, spectrum, weight, given, trial, scratch, candidates;
  double known = 0.0;  // cells with weight
  bool nearly_full = true;
  int chosen = -1;     // candidate of s; -1: none yet
  double least = 0.0;  // its score
};

RobustSmoother::RobustSmoother(const GridSpec& grid) {
  check(grid);
  work_ = std::make_unique<Work>(grid);
  work_->trial.resize(grid.size());
}
RobustSmoother::~RobustSmoother() = default;
RobustSmoother::RobustSmoother(RobustSmoother&&) noexcept = default;

Smoothed RobustSmoother::smooth(const HeightMap& height, const Grid<double>* weights,
                                const SmoothingOptions& o) {
  Work& w = *work_;
  if (height.size() != w.g.size() || (weights && weights->size() != w.g.size()))
    throw std::invalid_argument("smoothing: map or weights do not have the smoother's " +
                                std::to_string(w.g.size()) + " cells");
  if (!(o.s >= 0.0) || !std::isfinite(o.s))
    throw std::invalid_argument("smoothing: s = " + std::to_string(o.s) + " must be 0 or more");
  double mean = 0.0;
  w.known = 0.0;
  for (std::size_t c = 0; c < w.y.size(); ++c) {
    const double given = weights ? weights->cells[c] : 1.0;
    if (!(given >= 0.0 && given <= 1.0))
      throw std::invalid_argument("smoothing: weight " + std::to_string(given) + " of cell " +
                                  std::to_string(c) + " is outside 0..1");
    const bool has = std::isfinite(height.cells[c]) && given > 0.0;
    w.given[c] = has ? given : 0.0;
    w.y[c] = has ? height.cells[c] : 0.0;
    if (has) {
      mean += w.y[c];
      w.known += 1.0;
    }
  }
  Smoothed out{HeightMap(height.spec), 0.0, Grid<double>(height.spec), 0.0, 0};
  mean = w.known > 0.0 ? mean / w.known : 0.0;
  out.weights.cells = w.given;
  if (w.known < 3.0) {
    std::fill(out.height.cells.begin(), out.height.cells.end(), mean);
    return out;
  }
  double spread = 0.0;
  for (std::size_t c = 0; c < w.y.size(); ++c) {
    if (w.given[c] == 0.0) continue;
    w.y[c] -= mean;
    spread += w.y[c] * w.y[c];
  }
  spread = std::sqrt(spread / w.known);
  w.weight = w.given;
  fill_nearest(w.g, w.y, w.given);
  w.z = w.y;

  double sum = 0.0;
  for (const double v : w.given) sum += v;
  const bool full = sum == double(w.y.size());
  w.chosen = -1;
  out.s = o.s;
  for (int step = 0; step <= (o.robust ? o.robust_steps : 0); ++step) {
    const bool direct = full && step == 0;  // W = 1: the first pass is the solution
    sum = 0.0;
    for (const double v : w.weight) sum += v;
    w.nearly_full = sum > 0.9 * double(w.y.size());
    for (int n = 1; n <= o.max_iterations; ++n) {
      ++out.iterations;
      w.transform_data();
      if (o.s == 0.0 && (n == 1 || n == 4)) {  // the spectrum has settled by then
        w.search();
        out.s = w.candidates[std::size_t(w.chosen)];
      }
      const double move = w.iterate(out.s, direct ? 1.0 : 1.75);
      if (direct || move <= o.tolerance * spread) break;
    }
    if (o.robust && step < o.robust_steps) w.reweight(out.s);
  }
  double trace = 0.0;
  for (const double l : w.lambda2) trace += 1.0 / (1.0 + out.s * l);
  const double free = 1.0 - trace / double(w.y.size());
  if (free > 0.0) out.noise_std_mm = w.residual_std() / std::sqrt(free);
  out.weights.cells = w.weight;
  for (std::size_t c = 0; c < w.y.size(); ++c) out.height.cells[c] = w.z[c] + mean;
  return out;
}

}  // namespace firn::surface
