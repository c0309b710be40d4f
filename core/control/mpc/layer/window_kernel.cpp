#include "core/control/mpc/layer/window_kernel.h"

#include <algorithm>
#include <cstdint>

#include "core/grid/avx2.h"

namespace firn::control::mpc {
namespace {

typedef float Lanes
    __attribute__((vector_size(32), aligned(4), may_alias));  // clang has no such alignment of a using
using Marks = std::int32_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;

FIRN_INLINE const Lanes& lanes(const float* at) { return *reinterpret_cast<const Lanes*>(at); }
FIRN_INLINE Lanes& lanes(float* at) { return *reinterpret_cast<Lanes*>(at); }
// As macros, since a function that returns a vector has no fixed ABI without AVX.
#define FIRN_LESS(a, b) ((a) < (b) ? (a) : (b))
#define FIRN_TWICE(at) (Lanes{(at)[0], (at)[0], (at)[1], (at)[1], (at)[2], (at)[2], (at)[3], (at)[3]})

// Of the window whose latest 2 K + 2 cells are state n, n a multiple of eight, and whose first cell is
// `first`.
FIRN_INLINE const float* entries(int rows, const float* table, int n, int first) {
  return table + ((first << 2 | (n >> (2 * rows) & 3)) * 8 + (n >> rows & 7)) * 8;
}

}  // namespace

FIRN_CLONES void cost_table(float error, const std::array<float, 9>& adds, const CellCost& c, float* table) {
  float east[8];
  for (int l = 0; l < 8; ++l)
    east[l] = (l & 1 ? adds[6] : 0.0f) + (l & 2 ? adds[7] : 0.0f) + (l & 4 ? adds[8] : 0.0f);
  const Lanes of_east = lanes(east);
  for (int w = 0; w < 8; ++w) {
    const float west =
        error + ((w & 1 ? adds[0] : 0.0f) + (w & 2 ? adds[1] : 0.0f) + (w & 4 ? adds[2] : 0.0f));
    for (int m = 0; m < 8; ++m) {
      const float both =
          west + ((m & 1 ? adds[3] : 0.0f) + (m & 2 ? adds[4] : 0.0f) + (m & 4 ? adds[5] : 0.0f));
      const Lanes e = of_east + both;
      const Lanes size = Lanes(Marks(e) & (Marks{} + 0x7fffffff));
      lanes(table + (w * 8 + m) * 8) = c.absolute * size + (c.linear + c.square * e) * e;
    }
  }
}

void zero_table(float* table) { std::fill(table, table + kWindowPatterns, 0.0f); }
void bar_latest(float* table) {
  for (int i = 1; i < kWindowPatterns; i += 2) table[i] = kBarred;
}
void price_latest(float* table, float price) {
  for (int i = 1; i < kWindowPatterns; i += 2) table[i] += price;
}
void set_latest(float* table, bool drop) {
  for (int i = !drop; i < kWindowPatterns; i += 2) table[i] = kBarred;
}
FIRN_CLONES void add_shared(float* table, const float* shared_values, float factor) {
  for (int w = 0; w < 8; ++w)
    for (int m = 0; m < 8; ++m) {
      const float* v = shared_values + (w & 3) * 16 + (m & 3) * 4;
      const Lanes both = {v[0], v[1], v[2], v[3], v[0], v[1], v[2], v[3]};
      lanes(table + (w * 8 + m) * 8) += factor * both;
    }
}

FIRN_CLONES void step_forward(int rows, const float* before, const float* table, float* after) {
  const int states = int(profile_states(rows)), half = states / 2;
  for (int n = 0; n < states; n += kLanes) {
    const Lanes a = FIRN_TWICE(before + n / 2) + lanes(entries(rows, table, n, 0));
    const Lanes b = FIRN_TWICE(before + half + n / 2) + lanes(entries(rows, table, n, 1));
    lanes(after + n) = FIRN_LESS(a, b);
  }
}

FIRN_CLONES void step_backward(int rows, const float* after, const float* table, float* before) {
  const int states = int(profile_states(rows)), half = states / 2;
  for (int first = 0; first < 2; ++first)
    for (int n = 0; n < states; n += 2 * kLanes) {
      const Lanes a = lanes(after + n) + lanes(entries(rows, table, n, first));
      const Lanes b = lanes(after + n + kLanes) + lanes(entries(rows, table, n + kLanes, first));
      const Lanes without = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14);
      const Lanes with = __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15);
      lanes(before + first * half + n / 2) = FIRN_LESS(without, with);
    }
}

FIRN_CLONES void min_by_pattern(int rows, const float* before, const float* table, const float* after,
                                float* least) {
  const int states = int(profile_states(rows)), half = states / 2;
  float of_window[kWindowPatterns];
  std::fill(of_window, of_window + kWindowPatterns, 2.0f * kBarred);
  for (int first = 0; first < 2; ++first)
    for (int n = 0; n < states; n += kLanes) {
      const Lanes here = FIRN_TWICE(before + first * half + n / 2) + lanes(after + n);
      Lanes& best = lanes(of_window + (entries(rows, table, n, first) - table));
      best = FIRN_LESS(here, best);
    }
  for (int s = 0; s < 16; ++s) {
    const int w = s / 4 * 64, m = s % 4 * 8;
    Lanes best = lanes(of_window + w + m) + lanes(table + w + m);
    for (const int other : {w + m + 32, w + 256 + m, w + 256 + m + 32}) {
      const Lanes here = lanes(of_window + other) + lanes(table + other);
      best = FIRN_LESS(here, best);
    }
    for (int l = 0; l < 4; ++l) least[s * 4 + l] = std::min(best[l], best[l + 4]);
  }
}

FIRN_CLONES float take_off_least(int rows, float* values) {
  const int states = int(profile_states(rows));
  Lanes least = lanes(values);
  for (int n = kLanes; n < states; n += kLanes) least = FIRN_LESS(lanes(values + n), least);
  float x = least[0];
  for (int l = 1; l < kLanes; ++l) x = std::min(x, least[l]);
  for (int n = 0; n < states; n += kLanes) lanes(values + n) -= x;
  return x;
}

int state_before(int rows, const float* before, const float* table, int state) {
  const int half = int(profile_states(rows)) / 2, n = state & ~7;
  const float without = before[state >> 1] + entries(rows, table, n, 0)[state & 7];
  const float with = before[half + (state >> 1)] + entries(rows, table, n, 1)[state & 7];
  return (with < without ? half : 0) + (state >> 1);
}

}  // namespace firn::control::mpc
