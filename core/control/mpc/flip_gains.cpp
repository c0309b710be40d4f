// The gain of every single droplet of a row: LayerProblem::flip_gains.
#include <cmath>

#include "core/control/mpc/layer_problem.h"

namespace firn::control::mpc {

// The row's cells and their rows of neighbours, from the first cell on.
struct LayerProblem::Row {
  const float *height, *error;
  const std::uint8_t *counts, *drops;
  std::ptrdiff_t stride;
  const Ink& ink;
};

namespace {

#define FIRN_INLINE [[gnu::always_inline]] inline

constexpr int kChunk = 64;  // cells at a time: what is summed stays in the nearest cache

// Plain loops over neighbours, which the compiler makes into vectors; element by element, so the same bytes on any processor.
template <class Row>
FIRN_INLINE void gains_of_chunk(const Row& r, std::ptrdiff_t first, float* __restrict out) {
  float own[kChunk], sign[kChunk], sum[kChunk];
  const float* h = r.height + first;
  const std::uint8_t* drops = r.drops + first;
  for (int i = 0; i < kChunk; ++i) own[i] = r.ink.drop_mm, sum[i] = 0.0f;
  for (int i = 0; i < kChunk; ++i) sign[i] = drops[i] ? -1.0f : 1.0f;
  std::size_t q = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx, ++q) {
      if (q == 4) continue;
      const std::ptrdiff_t to = first + dy * r.stride + dx;
      const float *there = r.height + to, *error = r.error + to;
      const std::uint8_t* counted = r.counts + to;
      const float w = r.ink.w_mm[q], slope = r.ink.slope[q];
      for (int i = 0; i < kChunk; ++i) {
        float x = w + slope * (h[i] - there[i]);
        x = x < w ? x : w;
        x = x > 0.0f ? x : 0.0f;
        own[i] -= x;
        const float flow = counted[i] ? x : 0.0f;  // errors that do not count are 0 and stay so
        sum[i] += std::abs(error[i] + sign[i] * flow) - std::abs(error[i]);
      }
    }
  const float* error = r.error + first;
  const std::uint8_t* counts = r.counts + first;
  for (int i = 0; i < kChunk; ++i) {
    const float gain = sum[i] + (std::abs(error[i] + sign[i] * own[i]) - std::abs(error[i]));
    out[i] = counts[i] ? gain : 0.0f;
  }
}

template <class Row>
FIRN_INLINE void gains_of_row(const Row& r, int n, float* out) {
  for (int i = 0; i + kChunk <= n; i += kChunk) gains_of_chunk(r, i, out + i);
}

template <class Row>
void portable_row(const Row& r, int n, float* out) {
  gains_of_row(r, n, out);
}
#if defined(__x86_64__)
template <class Row>
__attribute__((target("avx2"))) void avx2_row(const Row& r, int n, float* out) {
  gains_of_row(r, n, out);
}
#endif

}  // namespace

void LayerProblem::flip_gains(int j, float* gains) const {
  int done = 0;
  if (inks_of_.empty()) {
    const std::size_t p = at(0, j);
    const Row row{height_.data() + p, error_.data() + p, counts_.data() + p, drops_.data() + p, std::ptrdiff_t(row_), inks_[0]};
    done = nx_ / kChunk * kChunk;
#if defined(__x86_64__)
    static const bool avx2 = __builtin_cpu_supports("avx2");
    avx2 ? avx2_row(row, nx_, gains) : portable_row(row, nx_, gains);
#else
    portable_row(row, nx_, gains);
#endif
  }
  for (int i = done; i < nx_; ++i) {
    const Effect f = effect(i, j);
    const float sign = drop(i, j) ? -1.0f : 1.0f;
    float gain = 0.0f;
    std::size_t q = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx, ++q) {
        const float e = error_[std::size_t(std::ptrdiff_t(at(i, j)) + dy * std::ptrdiff_t(row_) + dx)];
        gain += std::abs(e + sign * f[q]) - std::abs(e);
      }
    gains[i] = printable(i, j) ? gain : 0.0f;
  }
}

}  // namespace firn::control::mpc
