#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "core/control/mpc/layer/lanes.h"
#include "core/control/mpc/layer/layer_rows.h"
#include "core/grid/avx2.h"

namespace firn::control::mpc {
namespace {

constexpr std::size_t kBlock = kRowBlock;
constexpr std::uint64_t kAllOnes = 0x0101010101010101u;

FIRN_INLINE void spread(float x, Lanes& v) { v = Lanes{x, x, x, x, x, x, x, x}; }

FIRN_INLINE void load_marks(const std::int32_t* from, LaneMarks& v) { std::memcpy(&v, from, sizeof v); }
FIRN_INLINE void mask(Lanes& v, const LaneMarks& marks) { v = Lanes(LaneMarks(v) & marks); }
FIRN_INLINE void at_most(const Lanes& most, Lanes& v) { v = v < most ? v : most; }
FIRN_INLINE void at_least(const Lanes& least, Lanes& v) { v = v > least ? v : least; }

// out[l] = v[l - 1], out[0] the last of the lanes before; in two steps that AVX2 has
FIRN_INLINE void moved_on(const Lanes& before, const Lanes& v, Lanes& out) {
  const LaneMarks middle = __builtin_shufflevector(LaneMarks(before), LaneMarks(v), 4, 5, 6, 7, 8, 9, 10, 11);
  out = Lanes(__builtin_shufflevector(middle, LaneMarks(v), 3, 8, 9, 10, 7, 12, 13, 14));
}

struct InkLanes {
  Lanes w[2], slope[2], drop, zero, beyond;
};
FIRN_INLINE void lanes_of(const RowInk& ink, InkLanes& v) {
  for (int k = 0; k < 2; ++k) {
    spread(ink.w_mm[k], v.w[k]);
    spread(ink.slope[k], v.slope[k]);
  }
  spread(ink.drop_mm, v.drop);
  spread(ink.beyond_mm[0], v.beyond);
  v.zero = v.drop - v.drop;  // not a constant, so that a comparison and a choice become one maximum
}

// Flows of droplets on p to q, and of droplets on q to p: clamp(w +- slope (H_p - H_q), 0, w).
struct Pair {
  Lanes out, back;
};
FIRN_INLINE void exchanged(const InkLanes& ink, int corner, const Lanes& p, const float* q, Pair& pair) {
  Lanes there;
  load(q, there);
  const Lanes lean = ink.slope[corner] * (p - there);
  pair.out = ink.w[corner] + lean;
  pair.back = ink.w[corner] - lean;
  at_most(ink.w[corner], pair.out);
  at_most(ink.w[corner], pair.back);
  at_least(ink.zero, pair.out);
  at_least(ink.zero, pair.back);
}

FIRN_INLINE RowCells rows_on(const RowCells& r, std::ptrdiff_t rows) {
  const std::ptrdiff_t n = rows * r.stride;
  return {r.height_mm + n, r.bare_mm + n, r.error_mm + n, r.counts + n, r.drops + n, r.stride};
}

// Lets the cells of a row further on come nearer while this one is being computed.
FIRN_INLINE void ask_for(const RowCells& r, const float* of_errors, std::ptrdiff_t i, std::ptrdiff_t rows) {
  const std::ptrdiff_t n = i + rows * r.stride;
  if (i % 16 == 0) {
    __builtin_prefetch(r.height_mm + n);
    __builtin_prefetch(of_errors + n);
  }
  if (i % 64 == 0) {
    __builtin_prefetch(r.counts + n);
    __builtin_prefetch(r.drops + n);
  }
}

// All bits where a droplet is, of a row and a cell more at each end.
FIRN_INLINE void widen_marks(const std::uint8_t* __restrict drops, std::size_t n,
                             std::int32_t* __restrict marks) {
  for (std::size_t i = 0; i < n; ++i) marks[i] = -std::int32_t(drops[i]);
}

// Rows of four bytes a cell, so far apart that the same cells of many rows are not of one set of the cache.
constexpr std::size_t kept_apart(std::size_t cells) {
  return cells % 1024 >= 112 && cells % 1024 <= 912 ? cells : (cells + 111) / 1024 * 1024 + 112;
}

// Each pair of neighbours once: a row keeps the flows between its cells and those of the row below, by the
// upper cell; `out` only where there is a droplet. All rows from a cell before the first on.
struct Exchange {
  enum { kSouthWest, kSouth, kSouthEast };
  float *out[3], *back[3];
  std::int32_t *here, *below;
};

FIRN_INLINE void errors_of_row(const RowCells& r, const InkLanes& ink, std::ptrdiff_t nx, const Exchange& x,
                               float* error_mm) {
  Lanes north_west_out, north_west_back, east_out_before = {}, east_back_before = ink.beyond;
  load(x.out[Exchange::kSouthEast] - 1, north_west_out);
  load(x.back[Exchange::kSouthEast] - 1, north_west_back);
  for (std::ptrdiff_t i = 0; i < nx; i += std::ptrdiff_t(kBlock)) {
    Lanes h, error, own = ink.drop, flow, moved;
    LaneMarks fired, marks;
    load(r.height_mm + i, h);
    load(r.bare_mm + i, error);
    load_marks(x.here + i, fired);
    Pair east, south_west, south, south_east;
    exchanged(ink, 0, h, r.height_mm + i + 1, east);
    exchanged(ink, 1, h, r.height_mm + i + r.stride - 1, south_west);
    exchanged(ink, 0, h, r.height_mm + i + r.stride, south);
    exchanged(ink, 1, h, r.height_mm + i + r.stride + 1, south_east);
    // Above: north west, north, north east.
    error += north_west_out;
    own -= north_west_back;
    load(x.out[Exchange::kSouth] + i, flow);
    error += flow;
    load(x.back[Exchange::kSouth] + i, flow);
    own -= flow;
    load(x.out[Exchange::kSouthWest] + i + 1, flow);
    error += flow;
    load(x.back[Exchange::kSouthWest] + i + 1, flow);
    own -= flow;
    ask_for(r, r.bare_mm, i, 2);
    const std::ptrdiff_t last = i + std::ptrdiff_t(kBlock) - 1;
    load(x.out[Exchange::kSouthEast] + last, north_west_out);
    load(x.back[Exchange::kSouthEast] + last, north_west_back);
    // Beside: west, the cell itself, east.
    flow = east.out;
    mask(flow, fired);
    moved_on(east_out_before, flow, moved);
    error += moved;
    east_out_before = flow;
    moved_on(east_back_before, east.back, moved);
    own -= moved;
    east_back_before = east.back;
    own -= east.out;
    own -= south_west.out;
    own -= south.out;
    own -= south_east.out;
    mask(own, fired);
    error += own;
    load_marks(x.here + i + 1, marks);
    flow = east.back;
    mask(flow, marks);
    error += flow;
    // Below.
    load_marks(x.below + i - 1, marks);
    flow = south_west.back;
    mask(flow, marks);
    error += flow;
    load_marks(x.below + i, marks);
    flow = south.back;
    mask(flow, marks);
    error += flow;
    load_marks(x.below + i + 1, marks);
    flow = south_east.back;
    mask(flow, marks);
    error += flow;
    std::uint64_t counts;
    std::memcpy(&counts, r.counts + i, sizeof counts);
    if (counts != kAllOnes) {
      for (std::size_t l = 0; l < kBlock; ++l) marks[l] = -std::int32_t(r.counts[i + std::ptrdiff_t(l)]);
      mask(error, marks);
    }
    store(error, error_mm + i);
    const Pair* pairs[3] = {&south_west, &south, &south_east};
    for (int k = 0; k < 3; ++k) {
      flow = pairs[k]->out;
      mask(flow, fired);
      store(flow, x.out[k] + i);
      store(pairs[k]->back, x.back[k] + i);
    }
  }
}

FIRN_INLINE void errors_of_rows(RowCells r, const RowInk& plain, std::size_t nx, std::size_t rows,
                                float* error_mm) {
  InkLanes ink;
  lanes_of(plain, ink);
  const std::size_t width = whole_blocks(nx) + 2;
  const std::size_t apart = kept_apart(width);
  std::vector<float> flows(6 * apart);
  std::vector<std::int32_t> marks(2 * apart);
  Exchange x;
  for (std::size_t k = 0; k < 3; ++k) {
    x.out[k] = flows.data() + k * apart + 1;
    x.back[k] = flows.data() + (3 + k) * apart + 1;
    std::fill_n(x.back[k] - 1, width,
                plain.beyond_mm[k != Exchange::kSouth]);  // no droplets beyond the border; flows to it
  }
  x.here = marks.data() + 1;
  x.below = x.here + apart;
  widen_marks(r.drops - 1, width, x.here - 1);
  for (std::size_t j = 0; j < rows; ++j, error_mm += r.stride) {
    widen_marks(r.drops + r.stride - 1, width, x.below - 1);
    errors_of_row(r, ink, std::ptrdiff_t(nx), x, error_mm);
    std::swap(x.here, x.below);
    r = rows_on(r, 1);
  }
}

// Both functions for an instruction set.
#define FIRN_ROWS(suffix, attribute)                                                                     \
  attribute void errors_##suffix(const RowCells& r, const RowInk& ink, std::size_t nx, std::size_t rows, \
                                 float* out) {                                                           \
    errors_of_rows(r, ink, nx, rows, out);                                                               \
  }

FIRN_ROWS(portable, )
#if defined(__x86_64__)
FIRN_ROWS(avx2, __attribute__((target("avx2"))))
#endif

}  // namespace

std::span<const LayerRowKernels> layer_row_kernels() {
  static const std::array<LayerRowKernels, 2> all = {{
      {"portable", &errors_portable},
#if defined(__x86_64__)
      {"AVX2", &errors_avx2},
#endif
  }};
  return std::span(all).first(has_avx2() ? 2 : 1);
}

}  // namespace firn::control::mpc
