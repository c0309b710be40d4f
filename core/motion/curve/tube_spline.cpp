// The interior-point method of fit_spline.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/curve/constants.h"
#include "core/motion/curve/tube_newton.h"

namespace firn::motion {
namespace {

using Row = TubeWork::Row;

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

void set_energy(TubeWork& work) {
  const std::size_t cells = work.extended.size() - 7;
  work.energy.assign(cells + 3, {});
  work.form.resize(cells);
  for (std::size_t k = 0; k < cells; ++k) {
    const std::array<double, 4> form = third_derivative(work.extended, k);
    const double h =
        (work.extended[k + 4] - work.extended[k + 3]) * (work.weight.empty() ? 1.0 : work.weight[k]);
    for (std::size_t a = 0; a < 4; ++a) {
      work.form[k][a] = std::sqrt(h) * form[a];
      for (std::size_t b = a; b < 4; ++b) work.energy[k + a][b - a] += h * form[a] * form[b];
    }
  }
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

/// Least squares: the energy plus penalties on the distances from the places, larger and larger until the
/// spline is inside of all radii. The first `held` control points and the last one stay.
void move_near(std::size_t held, TubeWork& work) {
  const std::size_t n = work.control.size();
  const std::vector<Point2> first(work.control.begin(), work.control.begin() + std::ptrdiff_t(held));
  const Point2 last = work.control.back();
  double penalty = kFirstPenalty * tube::objective(work) / double(work.rows.size());
  for (int tries = 0; tries < kMaxPenalties; ++tries, penalty *= kPenaltyGrowth) {
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
    for (std::size_t k = 0; k <= held; ++k) {
      const std::size_t i = k < held ? k : n - 1;
      const Point2 end = k < held ? first[k] : last;
      const double weight = kEndPenalty * band[i][0];
      band[i][0] += weight;
      work.step[2 * i] += weight * end.x_mm;
      work.step[2 * i + 1] += weight * end.y_mm;
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
    std::copy(first.begin(), first.end(), work.control.begin());
    work.control.back() = last;
    double least = 1.0;
    for (Row& row : work.rows) {
      set_off(work, row);
      least = std::min(least, room(row));
    }
    if (least >= kMinTubeSlack) return;
  }
}

/// From the rows' first guesses: slacks, and multipliers for a gap. Returns the violation.
double set_states(double gap_per_row, TubeWork& work) {
  TubeWork::States& s = work.states;
  const std::size_t n = work.rows.size(), padded = (n + 3) / 4 * 4;
  for (auto* v : {&s.step, &s.change, &s.step_x, &s.step_y, &s.xx, &s.xy, &s.yy, &s.push_x, &s.push_y})
    v->assign(padded, 0.0);
  for (auto* v : {&s.off_x, &s.off_y, &s.over_square, &s.multiplier}) v->assign(padded, 0.0);
  for (auto* v : {&s.slack, &s.inside}) v->assign(padded, 1.0);
  double worst = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = work.rows[i];
    s.off_x[i] = row.off.x_mm;
    s.off_y[i] = row.off.y_mm;
    s.over_square[i] = row.over_square;
    s.inside[i] = room(row) >= kMinTubeSlack ? 1.0 : 0.0;
    s.slack[i] = std::max(room(row), kMinTubeSlack);
    s.multiplier[i] = gap_per_row / s.slack[i];
    worst = std::max(worst, -room(row));
  }
  return worst;
}

/// The spline with work.extended as knots. Returns the largest distance from a place over its radius.
double fit_extended(std::span<const TubePlace> places, bool near_places, std::size_t held, TubeWork& work) {
  set_energy(work);
  const std::span<const double> knots(work.extended.data() + 3, work.extended.size() - 6);
  const std::size_t n = work.control.size();
  work.band.resize(2 * n + TubeWork::kBehind);
  work.step.resize(2 * n + TubeWork::kBehind);
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
  work.converged = places.empty();
  if (places.empty()) return 1.0;
  if (near_places) move_near(held, work);
  const double terms = double(places.size());
  const bool steps = !work.base.empty();
  const double enough = near_places ? kSampleTubeGap : kTubeGap;
  const auto size = [&] {
    const double v = tube::objective(work);
    return steps ? std::max(-v, kStepGap / enough * work.value) : v;
  };
  double value = size(), stationary = 1.0,
         gap = steps         ? kFirstStepGap * work.value
               : near_places ? kFirstSampleTubeGap * value
                             : kFirstTubeGap * value,
         centring = kFirstTubeCentring;
  double worst = set_states(gap / terms, work);
  const auto left = [&](double gaps) {
    return value > 0.0 && (gap > gaps * value || worst > kTubeViolation || stationary > kStationary);
  };
  while (work.iterations < kMaxTubeIterations && left(enough)) {
    const double mu =
        std::max(centring * gap, worst > kTubeViolation ? kViolationCentring * enough * value : 0.0) / terms;
    tube::assemble(mu, held, work);
    if (!tube::solve(work)) break;
    const double length = tube::row_steps(mu, work);
    for (std::size_t i = 0; i < n; ++i) {
      work.control[i].x_mm += length * work.step[2 * i];
      work.control[i].y_mm += length * work.step[2 * i + 1];
    }
    const tube::Moved moved = tube::move_rows(length, work);
    gap = moved.gap;
    worst = moved.worst;
    value = size();
    stationary *= 1.0 - length;
    centring = std::clamp((1.0 - length) * (1.0 - length), kMinTubeCentring, kMaxTubeCentring);
    ++work.iterations;
  }
  work.converged = !left(kTubeGap);
  return std::sqrt(1.0 + worst);
}

/// A long spline in windows from one end to the other. A cell depends little on those far ahead: a window
/// goes on beyond the cells that are kept. The three control points that the next window shares with them
/// stay.
double fit_windows(std::span<const double> knots, std::span<const TubePlace> places, bool near_places,
                   TubeWork& work) {
  const std::size_t cells = knots.size() - 1;
  TubeWork part;
  const auto cut = [](const auto& all, std::size_t from, std::size_t to, auto& some) {
    some.clear();
    if (!all.empty()) some.assign(all.begin() + std::ptrdiff_t(from), all.begin() + std::ptrdiff_t(to));
  };
  std::vector<double>&off_x = work.states.off_x, &off_y = work.states.off_y;
  off_x.clear();
  off_y.clear();
  int iterations = 0;
  bool converged = true;
  double most = 0.0;
  for (std::size_t first = 0, end = 0, place = 0; end < cells;) {
    end = cells - first < 2 * kTubeWindowCells ? cells : first + kTubeWindowCells + kTubeOverlapCells;
    const std::size_t kept = end == cells ? cells : end - kTubeOverlapCells;
    cut(work.extended, first, end + 7, part.extended);
    cut(work.control, first, end + 3, part.control);
    cut(work.weight, first, end, part.weight);
    cut(work.base, first, end + 3, part.base);
    cut(work.linear, first, end + 3, part.linear);
    part.value = work.value;
    const auto before = [&](std::size_t cell) {
      if (cell == cells) return places.size();
      return std::size_t(std::lower_bound(places.begin(), places.end(), knots[cell],
                                          [](const TubePlace& p, double t) { return p.t < t; }) -
                         places.begin());
    };
    most = std::max(
        most, fit_extended(places.subspan(place, before(end) - place), near_places, first > 0 ? 3 : 1, part));
    std::copy(part.control.begin(), part.control.end(), work.control.begin() + std::ptrdiff_t(first));
    const auto taken = std::ptrdiff_t(before(kept) - place);
    off_x.insert(off_x.end(), part.states.off_x.begin(), part.states.off_x.begin() + taken);
    off_y.insert(off_y.end(), part.states.off_y.begin(), part.states.off_y.begin() + taken);
    iterations += part.iterations;
    converged = converged && part.converged;
    first = kept;
    place += std::size_t(taken);
  }
  work.iterations = iterations;
  work.converged = converged;
  return most;
}

}  // namespace

double fit_spline(std::span<const double> knots, std::span<const TubePlace> places, bool near_places,
                  TubeWork& work) {
  extend(knots, work.extended);
  if (knots.size() <= 3 * kTubeWindowCells) return fit_extended(places, near_places, 1, work);
  return fit_windows(knots, places, near_places, work);
}

}  // namespace firn::motion
