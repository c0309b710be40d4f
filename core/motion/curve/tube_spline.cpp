// The interior-point method of fit_spline.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "core/motion/curve/tube_fit.h"

namespace firn::motion {
namespace {

using Row = TubeWork::Row;

constexpr int kMostIterations = 40;
constexpr double kGap = 0.03;  ///< of the objective, where the iteration ends
/// The same of a step, as shares of the third derivative's integral, at its end and its start.
constexpr double kStepGap = 1e-4, kFirstStepGap = 0.1;
constexpr double kViolation = 0.005;  ///< of the squared radius
constexpr double kToBoundary = 0.95;
constexpr double kLeastSlack = 0.05;
constexpr double kStationary = 1e-2;  ///< of the first gradient of the Lagrangian

/// The four cubic B-splines that are not 0 in [knot[k + 3], knot[k + 4]] at t (Cox and de Boor).
std::array<double, 4> basis(const std::vector<double>& knot, std::size_t k, double t) {
  std::array<double, 4> n{1.0, 0.0, 0.0, 0.0};
  double left[4], right[4];
  for (std::size_t d = 1; d < 4; ++d) {
    left[d] = t - knot[k + 4 - d];
    right[d] = knot[k + 3 + d] - t;
    double saved = 0.0;
    for (std::size_t r = 0; r < d; ++r) {
      const double term = n[r] / (right[r + 1] + left[d - r]);
      n[r] = saved + right[r + 1] * term;
      saved = left[d - r] * term;
    }
    n[d] = saved;
  }
  return n;
}

/// The third derivative in cell k as a form of control points k .. k + 3.
std::array<double, 4> third_derivative(const std::vector<double>& knot, std::size_t k) {
  // differences of the unit control polygons, order by order
  std::array<double, 4> form{};
  for (std::size_t unit = 0; unit < 4; ++unit) {
    double c[4] = {};
    c[unit] = 1.0;
    for (std::size_t order = 0; order < 3; ++order)
      for (std::size_t j = 0; j + order < 3; ++j)
        c[j] = double(3 - order) * (c[j + 1] - c[j]) / (knot[k + j + 4] - knot[k + j + order + 1]);
    form[unit] = c[0];
  }
  return form;
}

void extend(std::span<const double> knots, std::vector<double>& extended) {
  extended.assign(3, knots.front());
  extended.insert(extended.end(), knots.begin(), knots.end());
  extended.insert(extended.end(), 3, knots.back());
}

void set_energy(std::span<const double> knots, TubeWork& work) {
  work.energy.assign(knots.size() + 2, {});
  work.form.resize(knots.size() - 1);
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const std::array<double, 4> form = third_derivative(work.extended, k);
    const double h = (knots[k + 1] - knots[k]) * (work.weight.empty() ? 1.0 : work.weight[k]);
    for (std::size_t a = 0; a < 4; ++a) {
      work.form[k][a] = std::sqrt(h) * form[a];
      for (std::size_t b = a; b < 4; ++b) work.energy[k + a][b - a] += h * form[a] * form[b];
    }
  }
}

/// The objective, and minus its gradient into work.step: from differences of control points, since the matrix
/// times their coordinates would be the small difference of large numbers.
double objective(TubeWork& work) {
  std::fill(work.step.begin(), work.step.end(), 0.0);
  double sum = 0.0;
  for (std::size_t k = 0; k < work.form.size(); ++k) {
    const std::array<double, 4>& form = work.form[k];
    const auto c = [&](std::size_t a) {
      Point2 p = work.control[k + a];
      if (!work.base.empty()) {
        p.x_mm -= work.base[k + a].x_mm;
        p.y_mm -= work.base[k + a].y_mm;
      }
      return p;
    };
    const Point2 first = c(0);
    double x = 0.0, y = 0.0;
    for (std::size_t a = 1; a < 4; ++a) {
      const Point2 p = c(a);
      x += form[a] * (p.x_mm - first.x_mm);
      y += form[a] * (p.y_mm - first.y_mm);
    }
    sum += x * x + y * y;
    for (std::size_t a = 0; a < 4; ++a) {
      work.step[2 * (k + a)] -= form[a] * x;
      work.step[2 * (k + a) + 1] -= form[a] * y;
    }
  }
  sum *= 0.5;
  for (std::size_t i = 0; i < work.linear.size(); ++i) {
    const Point2 g = work.linear[i];
    sum += g.x_mm * (work.control[i].x_mm - work.base[i].x_mm) +
           g.y_mm * (work.control[i].y_mm - work.base[i].y_mm);
    work.step[2 * i] -= g.x_mm;
    work.step[2 * i + 1] -= g.y_mm;
  }
  return sum;
}

/// Size of the objective: of the whole third derivative where the objective is that of a step.
double scale_of(const TubeWork& work) {
  double sum = 0.0;
  for (std::size_t k = 0; k < work.form.size(); ++k) {
    double x = 0.0, y = 0.0;
    for (std::size_t a = 1; a < 4; ++a) {
      x += work.form[k][a] * (work.control[k + a].x_mm - work.control[k].x_mm);
      y += work.form[k][a] * (work.control[k + a].y_mm - work.control[k].y_mm);
    }
    sum += x * x + y * y;
  }
  return 0.5 * sum;
}

void set_off(const TubeWork& work, Row& row) {
  Point2 p{-row.at.x_mm, -row.at.y_mm};
  for (std::size_t a = 0; a < 4; ++a) {
    p.x_mm += row.basis[a] * work.control[row.first + a].x_mm;
    p.y_mm += row.basis[a] * work.control[row.first + a].y_mm;
  }
  row.off = p;
}

double room(const Row& row) {
  return 1.0 - (row.off.x_mm * row.off.x_mm + row.off.y_mm * row.off.y_mm) * row.over_square;
}

constexpr std::size_t kWidth = std::tuple_size_v<decltype(TubeWork::band)::value_type>;

/// Two doubles side by side.
using Pair = double __attribute__((vector_size(16)));

/// From the rows that are k = 1 to 7 below, row[k ..] times row[k] / row[0] is taken, by pairs: rows are read
/// as they were written. @param row entries 0 to 7; odd: 1 to 7 and a zero
template <std::size_t k>
inline void eliminate(const Pair (&row)[4], const Pair (&odd)[4], double over,
                      std::array<double, kWidth>* below) {
  if constexpr (k < kWidth) {
    const double factor = row[k / 2][k % 2] * over;
    const Pair twice{factor, factor};
#pragma GCC unroll 4
    for (std::size_t m = k / 2; m < 4; ++m) {
      double* const at = below[k].data() + 2 * (m - k / 2);
      Pair value;
      std::memcpy(&value, at, sizeof value);
      value -= twice * (k % 2 ? odd[m] : row[m]);
      std::memcpy(at, &value, sizeof value);
    }
    eliminate<k + 1>(row, odd, over, below);
  }
}

/// Newton's matrix and right-hand side for the barrier parameter mu. @pre work.step is minus the gradient
void assemble(double mu, TubeWork& work) {
  const std::size_t n = work.control.size();
  for (std::size_t i = 0; i < n; ++i) {
    auto &x = work.band[2 * i], &y = work.band[2 * i + 1];
    x.fill(0.0);
    y.fill(0.0);
    for (std::size_t b = 0; b < 4; ++b) x[2 * b] = y[2 * b] = work.energy[i][b];
  }
  for (const Row& row : work.rows) {
    const double own = 2.0 * row.multiplier * row.over_square;
    const double gx = -2.0 * row.over_square * row.off.x_mm, gy = -2.0 * row.over_square * row.off.y_mm;
    const double over = 1.0 / row.slack, stiff = row.multiplier * over;
    const double xx = own + stiff * gx * gx, xy = stiff * gx * gy, yy = own + stiff * gy * gy;
    const double push = (mu - row.multiplier * (room(row) - row.slack)) * over;
    const std::array<double, 4> basis = row.basis;
    double* const step = &work.step[2 * row.first];
    auto* const band = &work.band[2 * row.first];
    const double right_x = push * gx, right_y = push * gy;
#pragma GCC unroll 4
    for (std::size_t a = 0; a < 4; ++a) {
      const double weight = basis[a];
      step[2 * a] += weight * right_x;
      step[2 * a + 1] += weight * right_y;
      double *const x = band[2 * a].data(), *const y = band[2 * a + 1].data();
      double w = weight * weight;
      x[0] += w * xx;
      x[1] += w * xy;
      y[0] += w * yy;
#pragma GCC unroll 4
      for (std::size_t b = a + 1; b < 4; ++b) {
        w = weight * basis[b];
        x[2 * (b - a)] += w * xx;
        x[2 * (b - a) + 1] += w * xy;
        y[2 * (b - a) - 1] += w * xy;
        y[2 * (b - a)] += w * yy;
      }
    }
  }
  // both ends stay
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, 2 * n - 2, 2 * n - 1}) {
    work.step[i] = 0.0;
    for (std::size_t b = 1; b < 8; ++b) {
      work.band[i][b] = 0.0;
      if (b <= i) work.band[i - b][b] = 0.0;
    }
    work.band[i][0] = 1.0;
  }
}

/// @pre work.band has kWidth - 1 rows more than unknowns, and work.step as many entries
bool solve(TubeWork& work) {
  const std::size_t n = 2 * work.control.size();
  // the rows behind the last one take what is eliminated beyond it: 0
  for (std::size_t i = n; i < n + kWidth - 1; ++i) {
    work.band[i].fill(0.0);
    work.step[i] = 0.0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, kWidth>* const band = &work.band[i];
    Pair row[4];
    std::memcpy(row, band->data(), sizeof row);
    if (!(row[0][0] > 0.0)) return false;
    const double over = 1.0 / row[0][0], value = work.step[i] * over;
    // by shuffles: loads across what was stored just before would wait for it
    const Pair odd[4] = {
        __builtin_shufflevector(row[0], row[1], 1, 2), __builtin_shufflevector(row[1], row[2], 1, 2),
        __builtin_shufflevector(row[2], row[3], 1, 2), __builtin_shufflevector(row[3], Pair{}, 1, 2)};
    eliminate<1>(row, odd, over, band);
    double* const step = &work.step[i];
#pragma GCC unroll 7
    for (std::size_t k = 1; k < kWidth; ++k) step[k] -= row[k / 2][k % 2] * value;
    (*band)[0] = over;
    step[0] = value;
  }
  for (std::size_t i = n; i-- > 0;) {  // what was found last comes last
    const auto& row = work.band[i];
    double sum = 0.0;
#pragma GCC unroll 6
    for (std::size_t k = kWidth - 1; k > 1; --k) sum += row[k] * work.step[i + k];
    work.step[i] -= row[0] * (sum + row[1] * work.step[i + 1]);
  }
  return true;
}

/// Least squares: the energy plus penalties on the distances from the places, larger and larger until the
/// spline is inside of all radii.
void move_near(TubeWork& work) {
  constexpr double kFirst = 100.0, kMore = 30.0, kEnds = 1e9;
  constexpr int kTries = 8;
  const std::size_t n = work.control.size();
  const Point2 first = work.control.front(), last = work.control.back();
  double penalty = kFirst * objective(work) / double(work.rows.size());
  for (int tries = 0; tries < kTries; ++tries, penalty *= kMore) {
    auto& band = work.near;
    band.assign(work.energy.begin(), work.energy.end());
    std::fill(work.step.begin(), work.step.end(), 0.0);
    for (const Row& row : work.rows)
      for (std::size_t a = 0; a < 4; ++a) {
        const double weight = penalty * row.over_square * row.basis[a];
        work.step[2 * (row.first + a)] += weight * row.at.x_mm;
        work.step[2 * (row.first + a) + 1] += weight * row.at.y_mm;
        for (std::size_t b = a; b < 4; ++b) band[row.first + a][b - a] += weight * row.basis[b];
      }
    for (const auto& [end, i] : {std::pair{first, std::size_t{0}}, {last, n - 1}}) {
      const double held = kEnds * band[i][0];
      band[i][0] += held;
      work.step[2 * i] += held * end.x_mm;
      work.step[2 * i + 1] += held * end.y_mm;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const double over = 1.0 / band[i][0];
      for (std::size_t k = 1; k < 4 && i + k < n; ++k) {
        const double factor = band[i][k] * over;
        for (std::size_t m = k; m < 4; ++m) band[i + k][m - k] -= factor * band[i][m];
        work.step[2 * (i + k)] -= factor * work.step[2 * i];
        work.step[2 * (i + k) + 1] -= factor * work.step[2 * i + 1];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      Point2 p{work.step[2 * i], work.step[2 * i + 1]};
      for (std::size_t k = 1; k < 4 && i + k < n; ++k) {
        p.x_mm -= band[i][k] * work.control[i + k].x_mm;
        p.y_mm -= band[i][k] * work.control[i + k].y_mm;
      }
      work.control[i] = {p.x_mm / band[i][0], p.y_mm / band[i][0]};
    }
    work.control.front() = first;
    work.control.back() = last;
    double least = 1.0;
    for (Row& row : work.rows) {
      set_off(work, row);
      least = std::min(least, room(row));
    }
    if (least >= kLeastSlack) return;
  }
}

/// Largest step for which the room of a row that is inside stays above a share of it: a quadratic; for
/// another row, its slack.
double longest_step(const Row& row) {
  if (!row.inside) return row.step < 0.0 ? -kToBoundary * row.slack / row.step : 1.0;
  const double bend = row.over_square * (row.step_x * row.step_x + row.step_y * row.step_y);
  if (!(bend > 0.0)) return 1.0;
  const double left = kToBoundary * room(row);
  return 2.0 * left / (std::sqrt(row.step * row.step + 4.0 * bend * left) - row.step);
}

/// Steps of slacks, multipliers and distances. Returns the longest step of all.
double row_steps(double mu, TubeWork& work) {
  double longest = 1.0;
  for (Row& row : work.rows) {
    double sx = 0.0, sy = 0.0;
    for (std::size_t a = 0; a < 4; ++a) {
      sx += row.basis[a] * work.step[2 * (row.first + a)];
      sy += row.basis[a] * work.step[2 * (row.first + a) + 1];
    }
    row.step_x = sx;
    row.step_y = sy;
    row.step = room(row) - row.slack - 2.0 * row.over_square * (row.off.x_mm * sx + row.off.y_mm * sy);
    row.change = (mu - row.multiplier * (row.slack + row.step)) / row.slack;
    longest = std::min(longest, longest_step(row));
    if (row.change < 0.0) longest = std::min(longest, -kToBoundary * row.multiplier / row.change);
  }
  return longest;
}

}  // namespace

double fit_spline(std::span<const double> knots, std::span<const TubePlace> places, bool near_places,
                  TubeWork& work) {
  extend(knots, work.extended);
  set_energy(knots, work);
  const std::size_t n = work.control.size();
  work.band.resize(2 * n + kWidth - 1);
  work.step.resize(2 * n + kWidth - 1);
  work.rows.resize(places.size());
  std::size_t cell = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    while (cell + 2 < knots.size() && places[i].t >= knots[cell + 1]) ++cell;
    Row& row = work.rows[i];
    row.basis = basis(work.extended, cell, places[i].t);
    row.first = cell;
    row.at = places[i].at;
    row.over_square = 1.0 / (places[i].radius * places[i].radius);
    set_off(work, row);
  }
  work.iterations = 0;
  if (places.empty()) return 1.0;
  if (near_places) move_near(work);
  const double terms = double(places.size());
  const bool steps = !work.base.empty();
  const double least = steps ? kStepGap / kGap * scale_of(work) : 0.0;
  const auto size = [&] {
    const double v = objective(work);
    return steps ? std::max(std::abs(v), least) : v;
  };
  double value = size(), gap = 0.3 * (steps ? kFirstStepGap * scale_of(work) : value), worst = 0.0,
         stationary = 1.0, centring = 0.3;
  for (Row& row : work.rows) {
    row.inside = room(row) >= kLeastSlack;
    row.slack = std::max(room(row), kLeastSlack);
    row.multiplier = gap / terms / row.slack;
    worst = std::max(worst, -room(row));
  }
  while (work.iterations < kMostIterations && value > 0.0 &&
         (gap > kGap * value || worst > kViolation || stationary > kStationary)) {
    const double mu = std::max(centring * gap, worst > kViolation ? 0.2 * kGap * value : 0.0) / terms;
    assemble(mu, work);
    if (!solve(work)) break;
    const double length = row_steps(mu, work);
    for (std::size_t i = 0; i < n; ++i) {
      work.control[i].x_mm += length * work.step[2 * i];
      work.control[i].y_mm += length * work.step[2 * i + 1];
    }
    gap = worst = 0.0;
    for (Row& row : work.rows) {
      row.slack += length * row.step;
      row.multiplier += length * row.change;
      row.off.x_mm += length * row.step_x;
      row.off.y_mm += length * row.step_y;
      const double inside = room(row);
      if (row.inside || inside >= row.slack) {
        row.slack = inside;
        row.inside = true;
      }
      worst = std::max(worst, -inside);
      gap += row.slack * row.multiplier;
    }
    value = size();
    stationary *= 1.0 - length;
    centring = std::clamp((1.0 - length) * (1.0 - length), 0.05, 0.9);
    ++work.iterations;
  }
  return std::sqrt(1.0 + worst);
}

}  // namespace firn::motion
