// The loops of Newton's steps. Sums are in the order of the path with every instruction set.
#include "core/motion/curve/tube_newton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "core/grid/avx2.h"

namespace firn::motion::tube {
namespace {

using Pair = double __attribute__((vector_size(16)));
using Quad = double __attribute__((vector_size(32)));
using Row = TubeWork::Row;

template <class Vector>
FIRN_INLINE void read(const double* from, Vector& to) {
  std::memcpy(&to, from, sizeof to);
}

template <class Vector>
FIRN_INLINE void write(const Vector& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

template <class Vector>
FIRN_INLINE void add(const Vector& what, double* to) {
  Vector value;
  read(to, value);
  value += what;
  write(value, to);
}

template <class Vector>
FIRN_INLINE void subtract(const Vector& what, double* from) {
  Vector value;
  read(from, value);
  value -= what;
  write(value, from);
}

/// 1 - |off|^2 / radius^2
FIRN_INLINE void room_of(const Quad& off_x, const Quad& off_y, const Quad& over_square, Quad& room) {
  room = 1.0 - (off_x * off_x + off_y * off_y) * over_square;
}

/// The barrier's part of each row's Hessian and gradient, by coordinates.
FIRN_INLINE void barrier(double mu, TubeWork::States& s) {
  for (std::size_t i = 0; i < s.size(); i += 4) {
    Quad off_x, off_y, over_square, slack, multiplier, room;
    read(&s.off_x[i], off_x);
    read(&s.off_y[i], off_y);
    read(&s.over_square[i], over_square);
    read(&s.slack[i], slack);
    read(&s.multiplier[i], multiplier);
    room_of(off_x, off_y, over_square, room);
    const Quad own = 2.0 * multiplier * over_square;
    const Quad gx = -2.0 * over_square * off_x, gy = -2.0 * over_square * off_y;
    const Quad over = 1.0 / slack, stiff = multiplier * over;
    const Quad push = (mu - multiplier * (room - slack)) * over;
    write(own + stiff * gx * gx, &s.xx[i]);
    write(stiff * gx * gy, &s.xy[i]);
    write(own + stiff * gy * gy, &s.yy[i]);
    write(push * gx, &s.push_x[i]);
    write(push * gy, &s.push_y[i]);
  }
}

/// The right-hand sides of a row and the eight below it.
struct Window {
  double own;
  Quad near, far;
};

/// Eliminates one unknown from the rows below. Rows of x have eight entries, those of y seven and a zero.
/// False: its pivot is not positive.
template <bool kX>
FIRN_INLINE bool eliminate(TubeWork::BandRow* band, double* step, Window& window) {
  Quad low, high;
  read(band->at, low);
  read(band->at + 4, high);
  if (!(low[0] > 0.0)) return false;
  const double over = 1.0 / low[0], value = window.own * over;
  // by shuffles: loads across what was stored just before would wait for it
  const Quad zero{};
  const Quad from[8] = {low,
                        __builtin_shufflevector(low, high, 1, 2, 3, 4),
                        __builtin_shufflevector(low, high, 2, 3, 4, 5),
                        __builtin_shufflevector(low, high, 3, 4, 5, 6),
                        high,
                        __builtin_shufflevector(high, zero, 1, 2, 3, 4),
                        __builtin_shufflevector(high, zero, 2, 3, 4, 4),
                        __builtin_shufflevector(high, zero, 3, 4, 4, 4)};
  constexpr std::size_t kBelow = kX ? 8 : 7;
#pragma GCC unroll 8
  for (std::size_t k = 1; k < kBelow; ++k) {
    const double entry = band->at[k];
    const Quad factor = Quad{entry, entry, entry, entry} * over;
    subtract(factor * from[k], band[k].at);
    if (k + 4 < kBelow) subtract(factor * from[k + 4], band[k].at + 4);
  }
  const Quad near = window.near - from[1] * value, far = window.far - from[5] * value;
  const double next = step[9];
  window.own = near[0];
  window.near = __builtin_shufflevector(near, far, 1, 2, 3, 4);
  window.far = __builtin_shufflevector(far, Quad{next, next, next, next}, 1, 2, 3, 4);
  band->at[0] = over;
  *step = value;
  return true;
}

/// Largest steps for which the room of rows that are inside stays above a share of it: a quadratic; for other
/// rows, their slack.
FIRN_INLINE void longest_steps(const Quad& inside, const Quad& slack, const Quad& room, const Quad& bend,
                               const Quad& step, Quad& longest) {
  const Quad left = kTubeToBoundary * room, square = step * step + 4.0 * bend * left;
  Quad root;
  for (int k = 0; k < 4; ++k) root[k] = std::sqrt(square[k]);
  const Quad one = Quad{} + 1.0;
  const Quad within = bend > 0.0 ? 2.0 * left / (root - step) : one;
  const Quad outside = step < 0.0 ? -kTubeToBoundary * slack / step : one;
  longest = inside != 0.0 ? within : outside;
}

}  // namespace

FIRN_CLONES double objective(TubeWork& work) {
  const std::size_t cells = work.form.size();
  const bool moved = !work.base.empty();
  const auto control = [&](std::size_t i, Pair& at) {
    read(&work.control[i].x_mm, at);
    if (!moved) return;
    Pair base;
    read(&work.base[i].x_mm, base);
    at -= base;
  };
  double sum = 0.0;
  Pair c[4], step[4] = {};  // of the four control points of a cell
  for (std::size_t i = 0; i < 3; ++i) control(i, c[i + 1]);
  for (std::size_t k = 0; k < cells; ++k) {
    const std::array<double, 4>& form = work.form[k];
    for (std::size_t a = 0; a < 3; ++a) c[a] = c[a + 1];
    control(k + 3, c[3]);
    Pair third{};
#pragma GCC unroll 3
    for (std::size_t a = 1; a < 4; ++a) third += Pair{form[a], form[a]} * (c[a] - c[0]);
    const Pair square = third * third;
    sum += square[0] + square[1];
#pragma GCC unroll 4
    for (std::size_t a = 0; a < 4; ++a) step[a] -= Pair{form[a], form[a]} * third;
    write(step[0], &work.step[2 * k]);
    for (std::size_t a = 0; a < 3; ++a) step[a] = step[a + 1];
    step[3] = Pair{};
  }
  for (std::size_t i = 0; i < 3; ++i) write(step[i], &work.step[2 * (cells + i)]);
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

FIRN_CLONES void assemble(double mu, std::size_t held, TubeWork& work) {
  const std::size_t n = work.control.size();
  for (std::size_t i = 0; i < n; ++i) {
    Quad energy;
    read(work.energy[i].data(), energy);
    const Quad left = __builtin_shufflevector(energy, Quad{}, 0, 4, 1, 4),
               right = __builtin_shufflevector(energy, Quad{}, 2, 4, 3, 4);
    for (std::size_t k = 2 * i; k < 2 * i + 2; ++k) {
      write(left, work.band[k].at);
      write(right, work.band[k].at + 4);
    }
  }
  TubeWork::States& s = work.states;
  barrier(mu, s);
  const double *const xx = s.xx.data(), *const xy = s.xy.data(), *const yy = s.yy.data(),
                      *const push_x = s.push_x.data(), *const push_y = s.push_y.data();
  TubeWork::BandRow* const all = work.band.data();
  double* const steps = work.step.data();
  const Row* const rows = work.rows.data();
  const std::size_t count = work.rows.size();
  const Quad zero{};
  for (std::size_t i = 0; i < count; ++i) {
    const Quad x{xx[i], xy[i], xx[i], xy[i]}, y{yy[i], xy[i], yy[i], xy[i]};
    const Quad push{push_x[i], push_y[i], push_x[i], push_y[i]};
    Quad basis;
    read(rows[i].basis.data(), basis);
    double* const step = steps + 2 * rows[i].first;
    add(__builtin_shufflevector(basis, basis, 0, 0, 1, 1) * push, step);
    add(__builtin_shufflevector(basis, basis, 2, 2, 3, 3) * push, step + 4);
    // w: products with the control points from a on. Rows of x have the columns x, y of each, those of y
    // begin with their own
    TubeWork::BandRow* const band = all + 2 * rows[i].first;
    Quad w = basis[0] * basis;
    add(__builtin_shufflevector(w, w, 0, 0, 1, 1) * x, band[0].at);
    add(__builtin_shufflevector(w, w, 2, 2, 3, 3) * x, band[0].at + 4);
    add(__builtin_shufflevector(w, w, 0, 1, 1, 2) * y, band[1].at);
    add(__builtin_shufflevector(w, zero, 2, 3, 3, 4) * y, band[1].at + 4);
    w = basis[1] * basis;
    add(__builtin_shufflevector(w, w, 1, 1, 2, 2) * x, band[2].at);
    add(__builtin_shufflevector(w, zero, 3, 3, 4, 4) * x, band[2].at + 4);
    add(__builtin_shufflevector(w, w, 1, 2, 2, 3) * y, band[3].at);
    add(__builtin_shufflevector(w, zero, 3, 4, 4, 4) * y, band[3].at + 4);
    w = basis[2] * basis;
    add(__builtin_shufflevector(w, w, 2, 2, 3, 3) * x, band[4].at);
    add(__builtin_shufflevector(w, zero, 2, 3, 3, 4) * y, band[5].at);
    w = basis[3] * basis;
    add(__builtin_shufflevector(w, zero, 3, 3, 4, 4) * x, band[6].at);
    add(__builtin_shufflevector(w, zero, 3, 4, 4, 4) * y, band[7].at);
  }
  // both ends stay
  for (std::size_t k = 0; k < 2 * (held + 1); ++k) {
    const std::size_t i = k < 2 * held ? k : 2 * (n - 1 - held) + k;
    work.step[i] = 0.0;
    for (std::size_t b = 1; b < TubeWork::kWidth; ++b) {
      work.band[i].at[b] = 0.0;
      if (b <= i) work.band[i - b].at[b] = 0.0;
    }
    work.band[i].at[0] = 1.0;
  }
}

FIRN_CLONES bool solve(TubeWork& work) {
  const std::size_t n = 2 * work.control.size();
  // the rows behind the last one take what is eliminated beyond it: 0
  for (std::size_t i = n; i < n + TubeWork::kBehind; ++i) {
    std::fill_n(work.band[i].at, TubeWork::kWidth, 0.0);
    work.step[i] = 0.0;
  }
  double* const step = work.step.data();
  TubeWork::BandRow* const band = work.band.data();
  Window window{step[0], {}, {}};
  read(step + 1, window.near);
  read(step + 5, window.far);
  for (std::size_t i = 0; i < n; i += 2)
    if (!eliminate<true>(band + i, step + i, window) || !eliminate<false>(band + i + 1, step + i + 1, window))
      return false;
  for (std::size_t i = n; i-- > 0;) {  // what was found last comes last
    const double* const row = band[i].at;
    double sum = 0.0;
#pragma GCC unroll 6
    for (std::size_t k = TubeWork::kWidth - 1; k > 1; --k) sum += row[k] * step[i + k];
    step[i] -= row[0] * (sum + row[1] * step[i + 1]);
  }
  return true;
}

FIRN_CLONES double row_steps(double mu, TubeWork& work) {
  TubeWork::States& s = work.states;
  const double* const steps = work.step.data();
  double *const step_x = s.step_x.data(), *const step_y = s.step_y.data();
  const Row* const rows = work.rows.data();
  const std::size_t count = work.rows.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double* const basis = rows[i].basis.data();
    Pair step{};
#pragma GCC unroll 4
    for (std::size_t a = 0; a < 4; ++a) {
      Pair of;
      read(steps + 2 * (rows[i].first + a), of);
      step += Pair{basis[a], basis[a]} * of;
    }
    step_x[i] = step[0];
    step_y[i] = step[1];
  }
  Quad longest = Quad{} + 1.0;
  for (std::size_t i = 0; i < s.size(); i += 4) {
    Quad off_x, off_y, over_square, slack, multiplier, inside, sx, sy, room, here;
    read(&s.off_x[i], off_x);
    read(&s.off_y[i], off_y);
    read(&s.over_square[i], over_square);
    read(&s.slack[i], slack);
    read(&s.multiplier[i], multiplier);
    read(&s.inside[i], inside);
    read(&s.step_x[i], sx);
    read(&s.step_y[i], sy);
    room_of(off_x, off_y, over_square, room);
    const Quad step = room - slack - 2.0 * over_square * (off_x * sx + off_y * sy);
    const Quad change = (mu - multiplier * (slack + step)) / slack;
    write(step, &s.step[i]);
    write(change, &s.change[i]);
    longest_steps(inside, slack, room, over_square * (sx * sx + sy * sy), step, here);
    longest = here < longest ? here : longest;
    const Quad positive = change < 0.0 ? -kTubeToBoundary * multiplier / change : longest;
    longest = positive < longest ? positive : longest;
  }
  return std::min({longest[0], longest[1], longest[2], longest[3]});
}

FIRN_CLONES Moved move_rows(double length, TubeWork& work) {
  TubeWork::States& s = work.states;
  Quad worst{};
  for (std::size_t i = 0; i < s.size(); i += 4) {
    Quad step, off_x, off_y, over_square, slack, inside, room;
    read(&s.step_x[i], step);
    add(length * step, &s.off_x[i]);
    read(&s.change[i], step);
    add(length * step, &s.multiplier[i]);
    read(&s.step_y[i], step);
    add(length * step, &s.off_y[i]);
    read(&s.step[i], step);
    read(&s.slack[i], slack);
    slack += length * step;
    read(&s.off_x[i], off_x);
    read(&s.off_y[i], off_y);
    read(&s.over_square[i], over_square);
    read(&s.inside[i], inside);
    room_of(off_x, off_y, over_square, room);
    const Quad one = Quad{} + 1.0;
    inside = room >= slack ? one : inside;
    write(inside, &s.inside[i]);
    write(inside != 0.0 ? room : slack, &s.slack[i]);
    worst = -room > worst ? -room : worst;
  }
  Moved moved{0.0, std::max({worst[0], worst[1], worst[2], worst[3]})};
  for (std::size_t i = 0; i < work.rows.size(); ++i) moved.gap += s.slack[i] * s.multiplier[i];
  return moved;
}

}  // namespace firn::motion::tube
