// Whole rows of a LayerProblem at a time: the errors that its droplets leave, and the gain of every single droplet. Blocks of
// eight cells in registers; element by element, so the same bytes on any processor, with AVX2 or without.
#include <algorithm>
#include <cmath>

#include "core/control/mpc/flip_kernel.h"
#include "core/control/mpc/layer_problem.h"

namespace firn::control::mpc {

// The row's cells and their rows of neighbours, from the first cell on.
struct LayerProblem::Row {
  const float *height, *bare, *error;
  const std::uint8_t *counts, *drops;
  std::ptrdiff_t stride;
  const Ink& ink;
};

namespace {

constexpr int kBlock = 8;
using Bytes = std::uint8_t __attribute__((vector_size(8)));

// 0 or 1 a byte -> no bits or all bits a lane
FIRN_INLINE void marks_of(const std::uint8_t* from, LaneMarks& marks) {
  Bytes b;
  std::memcpy(&b, from, sizeof b);
  marks = -__builtin_convertvector(b, LaneMarks);
}

FIRN_INLINE void size_of(const Lanes& v, Lanes& out) { out = Lanes(LaneMarks(v) & 0x7fffffff); }

// Whether all cells of a block and their neighbours count.
template <class Row>
FIRN_INLINE bool all_count(const Row& r, std::ptrdiff_t first) {
  std::uint64_t all = ~std::uint64_t{0}, here;
  for (int dy = -1; dy <= 1; ++dy)
    for (const int dx : {-1, 1}) {
      std::memcpy(&here, r.counts + first + dy * r.stride + dx, sizeof here);
      all &= here;
    }
  return all == 0x0101010101010101u;
}

// The ink's numbers in all lanes: 0 sides, 1 corners.
struct InkLanes {
  Lanes w[2], slope[2], drop, zero;
};
FIRN_INLINE void spread(float x, Lanes& v) { v = Lanes{x, x, x, x, x, x, x, x}; }
template <class Ink>
FIRN_INLINE void lanes_of(const Ink& ink, InkLanes& v) {
  spread(ink.w_mm[1], v.w[0]), spread(ink.w_mm[0], v.w[1]);
  spread(ink.slope[1], v.slope[0]), spread(ink.slope[0], v.slope[1]);
  spread(ink.drop_mm, v.drop);
  v.zero = v.drop - v.drop;  // not a constant: so that clamp() is one minimum and one maximum
}

// clamp(w + lean, 0, w)
FIRN_INLINE void clamped(const InkLanes& ink, int corner, const Lanes& lean, Lanes& flow) {
  const Lanes x = ink.w[corner] + lean, y = x < ink.w[corner] ? x : ink.w[corner];
  flow = y > ink.zero ? y : ink.zero;
}

template <bool kAllCount, class Row>
FIRN_INLINE void gains_of_block(const Row& r, const InkLanes& ink, std::ptrdiff_t first, float* out) {
  Lanes h, there, own = ink.drop, sum = {}, before = {}, error, flow, now;
  load(r.height + first, h);
  LaneMarks taken, counted;
  marks_of(r.drops + first, taken);
  taken &= std::int32_t(0x80000000);  // the sign of a droplet less
  std::size_t q = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx, ++q) {
      const std::ptrdiff_t to = dy * r.stride + dx;
      load(r.error + first + to, error);
      size_of(error, now);
      before += now;
      if (q == 4) continue;
      load(r.height + first + to, there);
      const int corner = dx != 0 && dy != 0;
      clamped(ink, corner, ink.slope[corner] * (h - there), flow);
      own -= flow;
      if (!kAllCount) {  // errors that do not count are 0 and stay so
        marks_of(r.counts + first + to, counted);
        flow = Lanes(LaneMarks(flow) & counted);
      }
      size_of(error + Lanes(LaneMarks(flow) ^ taken), now);
      sum += now;
    }
  load(r.error + first, error);
  size_of(error + Lanes(LaneMarks(own) ^ taken), now);
  Lanes gain = (sum + now) - before;
  if (!kAllCount) {
    marks_of(r.counts + first, counted);
    gain = Lanes(LaneMarks(gain) & counted);
  }
  store(gain, out);
}

template <class Row>
FIRN_INLINE void gains_of_row(const Row& r, int n, float* out) {
  InkLanes ink;
  lanes_of(r.ink, ink);
  for (int i = 0; i + kBlock <= n; i += kBlock)
    all_count(r, i) ? gains_of_block<true>(r, ink, i, out + i) : gains_of_block<false>(r, ink, i, out + i);
}

// All bits where a droplet is, for a whole row.
FIRN_INLINE void widen_marks(const std::uint8_t* __restrict drops, std::size_t n, std::int32_t* __restrict marks) {
  for (std::size_t i = 0; i < n; ++i) marks[i] = -std::int32_t(drops[i]);
}

// bare + what the droplets of the nine cells bring, in the raster order of the droplets, as one after the other would.
// @param fired all bits where a droplet is, of the rows above, here and below
template <class Row>
FIRN_INLINE void errors_of_row(const Row& r, const std::int32_t* const fired[3], int n, float* out) {
  InkLanes ink;
  lanes_of(r.ink, ink);
  for (int i = 0; i + kBlock <= n; i += kBlock) {
    Lanes h, there, own = ink.drop, below[4], error, given_back;
    load(r.height + i, h), load(r.bare + i, error);
    LaneMarks here;
    std::size_t q = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx, ++q) {
        if (q == 4) continue;
        const std::ptrdiff_t to = dy * r.stride + dx;
        load(r.height + i + to, there);
        std::memcpy(&here, fired[dy + 1] + i + dx, sizeof here);
        const int corner = dx != 0 && dy != 0;
        const Lanes lean = ink.slope[corner] * (h - there);
        Lanes flow;
        clamped(ink, corner, lean, flow);
        clamped(ink, corner, -lean, given_back);
        own -= flow;
        given_back = Lanes(LaneMarks(given_back) & here);
        if (q < 4)
          error += given_back;
        else
          below[q - 5] = given_back;
      }
    std::memcpy(&here, fired[1] + i, sizeof here);
    error += Lanes(LaneMarks(own) & here);
    for (const Lanes& v : below) error += v;
    marks_of(r.counts + i, here);
    store(Lanes(LaneMarks(error) & here), out + i);
  }
}

// The rows' functions for an instruction set.
#define FIRN_ROWS(suffix, attribute)                                                                                    \
  template <class Row>                                                                                                  \
  attribute void gains_##suffix(const Row& r, int n, float* out) {                                                      \
    gains_of_row(r, n, out);                                                                                            \
  }                                                                                                                     \
  template <class Row>                                                                                                  \
  attribute void errors_##suffix(const Row& r, const std::int32_t* const fired[3], int n, float* out) {                 \
    errors_of_row(r, fired, n, out);                                                                                    \
  }                                                                                                                     \
  attribute void marks_##suffix(const std::uint8_t* drops, std::size_t n, std::int32_t* marks) { widen_marks(drops, n, marks); }

FIRN_ROWS(portable, )
#if defined(__x86_64__)
FIRN_ROWS(avx2, __attribute__((target("avx2"))))
const bool kAvx2 = __builtin_cpu_supports("avx2");
#define FIRN_WIDEST(function, ...) (kAvx2 ? function##_avx2(__VA_ARGS__) : function##_portable(__VA_ARGS__))
#else
#define FIRN_WIDEST(function, ...) function##_portable(__VA_ARGS__)
#endif

}  // namespace

LayerProblem::Row LayerProblem::row_at(int j) const {
  const std::size_t p = at(0, j);
  return {height_.data() + p, bare_.data() + p, error_.data() + p, counts_.data() + p, drops_.data() + p, std::ptrdiff_t(row_), inks_[0]};
}

void LayerProblem::flip_gains(int j, float* gains) const {
  const int done = inks_of_.empty() ? nx_ / kBlock * kBlock : 0;
  if (done > 0) FIRN_WIDEST(gains, row_at(j), nx_, gains);
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

void LayerProblem::refresh() {
  const int done = inks_of_.empty() ? nx_ / kBlock * kBlock : 0;
  std::vector<std::int32_t> marks(done > 0 ? 3 * row_ : 0);  // of three rows, row j at j % 3
  const auto marks_of_row = [&](int j) { return marks.data() + std::size_t((j + 3) % 3) * row_; };
  const auto widen = [&](int j) { FIRN_WIDEST(marks, drops_.data() + at(-1, j), row_, marks_of_row(j)); };
  if (done > 0) widen(-1), widen(0);
  for (int j = 0; j < ny_; ++j) {
    if (done > 0) {
      widen(j + 1);
      const std::int32_t* const fired[3] = {marks_of_row(j - 1) + 1, marks_of_row(j) + 1, marks_of_row(j + 1) + 1};
      FIRN_WIDEST(errors, row_at(j), fired, nx_, error_.data() + at(0, j));
    }
    for (int i = done; i < nx_; ++i) {
      const std::size_t p = at(i, j);
      float error = bare_[p];
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::size_t from = std::size_t(std::ptrdiff_t(p) + dy * std::ptrdiff_t(row_) + dx);
          if (drops_[from]) error += effect(i + dx, j + dy)[std::size_t((1 - dy) * 3 + 1 - dx)];
        }
      error_[p] = error;
    }
  }
}

}  // namespace firn::control::mpc
