#include "core/control/mpc/delta_cache.h"

#include <algorithm>

#include "core/control/mpc/flip_kernel.h"
#include "core/control/mpc/layer/lanes.h"
#include "core/grid/avx2.h"

namespace firn::control::mpc {
namespace {

constexpr int kLanes = 8;

FIRN_INLINE void size_of(Lanes& v) { v = Lanes(LaneMarks(v) & 0x7fffffff); }

// clamp(gives + lean, 0, gives); `zero` is no constant, so that it is one minimum and one maximum
FIRN_INLINE void clamped(const Lanes& gives, const Lanes& lean, const Lanes& zero, Lanes& out) {
  const Lanes x = gives + lean, y = x < gives ? x : gives;
  out = y > zero ? y : zero;
}

// Pairs (p, p + (kDx, kDy)): each pair of neighbours once.
constexpr int kLinks = 4, kDx[kLinks] = {1, -1, 0, 1}, kDy[kLinks] = {0, 1, 1, 1};

// Flows between the pairs of one layer at the present heights: from the first cell and to it.
struct PairFlows {
  float *gives[kLinks], *gets[kLinks];
};

// Eight pairs from p on, with their heights as they are.
template <int LINK>
FIRN_INLINE void note_pairs(const HorizonState& f, const HorizonState::Layer& l, const PairFlows& flows,
                            std::size_t p) {
  constexpr int corner = kDx[LINK] != 0 && kDy[LINK] != 0;
  const std::size_t q = std::size_t(std::ptrdiff_t(p) + kDy[LINK] * std::ptrdiff_t(f.row) + kDx[LINK]);
  Lanes hp, hq, give_p, give_q, lean_p, lean_q, out, back;
  load(l.height_mm.data() + p, hp);
  load(l.height_mm.data() + q, hq);
  load(l.gives_mm[corner].data() + p, give_p);
  load(l.gives_mm[corner].data() + q, give_q);
  load(l.slope[corner].data() + p, lean_p);
  load(l.slope[corner].data() + q, lean_q);
  const Lanes drop = hp - hq, zero = hp - hp;
  clamped(give_p, lean_p * drop, zero, out);
  clamped(give_q, -(lean_q * drop), zero, back);
  store(out, flows.gives[LINK] + p);
  store(back, flows.gets[LINK] + p);
}
FIRN_INLINE void note_all_pairs(const HorizonState& f, const HorizonState::Layer& l, const PairFlows& flows,
                                std::size_t p) {
  note_pairs<0>(f, l, flows, p);
  note_pairs<1>(f, l, flows, p);
  note_pairs<2>(f, l, flows, p);
  note_pairs<3>(f, l, flows, p);
}

// Changes of heights about eight cells, one cell a lane: of the cell x columns and y rows away.
struct Window {
  static constexpr int kReach = 3, kSide = 2 * kReach + 1;
  Lanes cells[kSide * kSide];
  FIRN_INLINE Lanes* at(int x, int y) { return cells + (y + kReach) * kSide + x + kReach; }
  FIRN_INLINE const Lanes* at(int x, int y) const { return cells + (y + kReach) * kSide + x + kReach; }
};

// Moves the change of a pair's flow from `next` of its first cell to that of the second.
template <int LINK>
FIRN_INLINE void exchange_pair(const HorizonState& f, const HorizonState::Layer& l, const PairFlows& flows,
                               std::size_t centre, int x, int y, const Lanes& zero, const Window& d,
                               Window& next) {
  constexpr int corner = kDx[LINK] != 0 && kDy[LINK] != 0;
  const std::size_t p = std::size_t(std::ptrdiff_t(centre) + y * std::ptrdiff_t(f.row) + x);
  const std::size_t q = std::size_t(std::ptrdiff_t(p) + kDy[LINK] * std::ptrdiff_t(f.row) + kDx[LINK]);
  Lanes hp, hq, give_p, give_q, lean_p, lean_q, out, back, out_now, back_now;
  load(l.height_mm.data() + p, hp);
  load(l.height_mm.data() + q, hq);
  load(l.gives_mm[corner].data() + p, give_p);
  load(l.gives_mm[corner].data() + q, give_q);
  load(l.slope[corner].data() + p, lean_p);
  load(l.slope[corner].data() + q, lean_q);
  load(flows.gives[LINK] + p, out);
  load(flows.gets[LINK] + p, back);
  const Lanes drop_now = (hp - hq) + (*d.at(x, y) - *d.at(x + kDx[LINK], y + kDy[LINK]));
  clamped(give_p, lean_p * drop_now, zero, out_now);
  clamped(give_q, -(lean_q * drop_now), zero, back_now);
  const Lanes change = (out_now - out) - (back_now - back);
  *next.at(x, y) -= change;
  *next.at(x + kDx[LINK], y + kDy[LINK]) += change;
}

// The pairs of one kind whose first cell is in row y, of which one cell at least is within R. From the east,
// in the order of flip_kernel.h: a cell's flow to the east before its flow from the west.
template <int LINK, int R>
FIRN_INLINE void exchange_row(const HorizonState& f, const HorizonState::Layer& l, const PairFlows& flows,
                              std::size_t centre, int y, const Lanes& zero, const Window& d, Window& next) {
  int first = -R, last = R;  // where the first cell is within R,
  if (y < -R) {
    first -= kDx[LINK];
    last -= kDx[LINK];
  }  // the second,
  else if (y + kDy[LINK] <= R) {
    first -= kDx[LINK] > 0;
    last += kDx[LINK] < 0;
  }  // either
  for (int x = last; x >= first; --x) exchange_pair<LINK>(f, l, flows, centre, x, y, zero, d, next);
}

// Changes before a layer, within R cells -> changes after it, within R + 1.
template <int R>
FIRN_INLINE void widen_all(const HorizonState& f, const HorizonState::Layer& l, const PairFlows& flows,
                           std::size_t centre, const Lanes& zero, const Window& d, Window& next) {
  for (int n = 0; n < Window::kSide * Window::kSide; ++n) next.cells[n] = d.cells[n];
  for (int y = -R; y <= R; ++y) exchange_row<0, R>(f, l, flows, centre, y, zero, d, next);
  for (int y = -R - 1; y <= R; ++y) {
    exchange_row<1, R>(f, l, flows, centre, y, zero, d, next);
    exchange_row<2, R>(f, l, flows, centre, y, zero, d, next);
    exchange_row<3, R>(f, l, flows, centre, y, zero, d, next);
  }
}

// The droplets of eight cells more or less.
FIRN_INLINE void first_changes(const HorizonState& f, const HorizonState::Layer& l, std::size_t p,
                               Lanes& zero, Window& d) {
  float sign[kLanes], drop[kLanes], gives[2][kLanes], slope[2][kLanes];
  for (std::size_t n = 0; n < kLanes; ++n) {
    const HorizonState::Ink& ink = f.ink[l.inks[p + n]];
    sign[n] = l.drops[p + n] ? -1.0f : 1.0f;
    drop[n] = ink.drop_mm;
    for (int k = 0; k < 2; ++k) {
      gives[k][n] = ink.gives_mm[k];
      slope[k][n] = ink.slope[k];
    }
  }
  Lanes signs, own, w[2], lean[2], h, there, flow;
  load(sign, signs);
  load(drop, own);
  load(l.height_mm.data() + p, h);
  for (int k = 0; k < 2; ++k) {
    load(gives[k], w[k]);
    load(slope[k], lean[k]);
  }
  zero = h - h;
  for (Lanes& v : d.cells) v = zero;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      if (x == 0 && y == 0) continue;
      const int corner = x != 0 && y != 0;
      load(l.height_mm.data() + std::size_t(std::ptrdiff_t(p) + y * std::ptrdiff_t(f.row) + x), there);
      clamped(w[corner], lean[corner] * (h - there), zero, flow);
      *d.at(x, y) = signs * flow;
      own -= flow;
    }
  *d.at(0, 0) = signs * own;
}

// The sums of a window, column by column: as flip_kernel.h has them in eight lanes, of which the first is
// empty.
template <int REACH, bool kAbsolute, bool kSquares>
FIRN_INLINE void sums_of_all(const HorizonState& f, std::size_t p, const Lanes& zero, const Window& d,
                             float* const (&halves)[6]) {
  Lanes worse[8], first[8], second[8];
  for (int x = 0; x < 8; ++x) worse[x] = first[x] = second[x] = zero;
  for (int y = -REACH; y <= REACH; ++y)
    for (int x = -REACH; x <= REACH; ++x) {
      const std::size_t c = std::size_t(std::ptrdiff_t(p) + y * std::ptrdiff_t(f.row) + x);
      Lanes e, counts;
      load(f.error_mm.data() + c, e);
      load(f.counts.data() + c, counts);
      const Lanes change = counts * *d.at(x, y), now = e + change;
      if (kAbsolute) {
        Lanes after = now, before = e;
        size_of(after);
        size_of(before);
        worse[x + 4] += after - before;
      }
      if (kSquares) {
        first[x + 4] += change;
        second[x + 4] += change * (e + now);
      }
    }
  const auto add = [&](const Lanes* v, std::size_t n) __attribute__((always_inline)) {
    store((v[0] + v[1]) + (v[2] + v[3]), halves[2 * n] + p);
    store((v[4] + v[5]) + (v[6] + v[7]), halves[2 * n + 1] + p);
  };
  if (kAbsolute) add(worse, 0);
  if (kSquares) {
    add(first, 1);
    add(second, 2);
  }
}

template <bool kAbsolute, bool kSquares>
FIRN_INLINE void look_at(const HorizonState& f, int layer, std::size_t p, const PairFlows* flows,
                         float* const (&halves)[6]) {
  Window a, b;
  Lanes zero;
  const auto of = [&](int n) -> const HorizonState::Layer& { return f.layers[std::size_t(layer + n)]; };
  first_changes(f, of(0), p, zero, a);
  const int later = f.horizon() - 1 - layer;
  if (later == 0) return sums_of_all<1, kAbsolute, kSquares>(f, p, zero, a, halves);
  widen_all<1>(f, of(1), flows[1], p, zero, a, b);
  if (later == 1) return sums_of_all<2, kAbsolute, kSquares>(f, p, zero, b, halves);
  widen_all<2>(f, of(2), flows[2], p, zero, b, a);
  sums_of_all<3, kAbsolute, kSquares>(f, p, zero, a, halves);
}

FIRN_INLINE void look_at_either(const HorizonState& f, int layer, std::size_t p, const PairFlows* flows,
                                bool absolute, bool squares, float* const (&halves)[6]) {
  if (absolute && squares)
    look_at<true, true>(f, layer, p, flows, halves);
  else if (absolute)
    look_at<true, false>(f, layer, p, flows, halves);
  else
    look_at<false, true>(f, layer, p, flows, halves);
}

FIRN_INLINE void do_flip(HorizonState& f, int layer, std::size_t p, const PairFlows* flows) {
  Flip flip;
  make_flip(f, layer, p, flip);
  ObjectiveDeltas s;
  sums_of(f, layer, p, flip, s);
  keep_flip(f, layer, p, flip, s);
  for (int m = std::max(layer, 1); m < f.horizon();
       ++m) {  // where the heights before layer m, or its droplets, have changed
    const int reach = m - layer;
    for (int y = -reach - 1; y <= reach; ++y)
      note_all_pairs(f, f.layers[std::size_t(m)], flows[m - layer],
                     std::size_t(std::ptrdiff_t(p) + y * std::ptrdiff_t(f.row) - Flip::kLane));
  }
}

FIRN_INLINE void note_layer(const HorizonState& f, int layer, const PairFlows& flows) {
  const std::size_t from = f.at(0) - f.row - kLanes, to = f.at(f.nx * f.ny - 1) + f.row + kLanes;
  for (std::size_t p = from; p < to; p += kLanes) note_all_pairs(f, f.layers[std::size_t(layer)], flows, p);
}

}  // namespace

struct DeltaCache::Kernels {
  void (*look)(const HorizonState& f, int layer, std::size_t p, const PairFlows* flows, bool absolute,
               bool squares, float* const (&halves)[6]);
  void (*flip)(HorizonState& f, int layer, std::size_t p, const PairFlows* flows);  // flows: from `layer` on
  void (*note)(const HorizonState& f, int layer, const PairFlows& flows);
};

namespace {
#define FIRN_FLIPS(suffix, attribute)                                                                   \
  attribute void look_##suffix(const HorizonState& f, int layer, std::size_t p, const PairFlows* flows, \
                               bool absolute, bool squares, float* const(&halves)[6]) {                 \
    look_at_either(f, layer, p, flows, absolute, squares, halves);                                      \
  }                                                                                                     \
  attribute void flip_##suffix(HorizonState& f, int layer, std::size_t p, const PairFlows* flows) {     \
    do_flip(f, layer, p, flows);                                                                        \
  }                                                                                                     \
  attribute void note_##suffix(const HorizonState& f, int layer, const PairFlows& flows) {              \
    note_layer(f, layer, flows);                                                                        \
  }
FIRN_FLIPS(portable, )
#if defined(__x86_64__)
FIRN_FLIPS(avx2, __attribute__((target("avx2"))))
#endif

template <class Layer>
PairFlows pairs_of(Layer& layer) {
  PairFlows flows;
  for (std::size_t k = 0; k < kLinks; ++k) {
    flows.gives[k] = layer.gives[k].data();
    flows.gets[k] = layer.gets[k].data();
  }
  return flows;
}

}  // namespace

DeltaCache::DeltaCache(HorizonState& field, Wanted wanted, Kernel kernel)
    : field_(field),
      wanted_(wanted),
      layers_(std::size_t(field.horizon())),
      kernels_([kernel]() -> const Kernels& {
        static const Kernels portable{&look_portable, &flip_portable, &note_portable};
#if defined(__x86_64__)
        static const Kernels avx2{&look_avx2, &flip_avx2, &note_avx2};
        if (kernel == Kernel::kWidest && has_avx2()) return avx2;
#endif
        return portable;
      }()) {
  const std::size_t n = field.error_mm.size();
  for (Layer& l : layers_) {
    l.fresh.assign(n, 0);
    for (std::size_t k = 0; k < l.halves.size(); ++k)
      if (k < 2 ? absolute() : squares()) l.halves[k].assign(n, 0.0f);
    for (auto* flows : {&l.gives, &l.gets})
      for (std::vector<float>& v : *flows) v.assign(&l == &layers_.front() ? 0 : n, 0.0f);
  }
  refresh();
}

void DeltaCache::refresh() {
  field_.refresh();
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    std::ranges::fill(layers_[k].fresh, std::uint8_t{0});
    if (k > 0) kernels_.note(field_, int(k), pairs_of(layers_[k]));
  }
}

void DeltaCache::look(int layer, std::size_t p) {
  Layer& l = layers_[std::size_t(layer)];
  std::array<PairFlows, HorizonState::kMaxLayers> flows;
  for (std::size_t k = std::size_t(layer); k < layers_.size(); ++k)
    flows[k - std::size_t(layer)] = pairs_of(layers_[k]);
  float* halves[6];
  for (std::size_t n = 0; n < 6; ++n) halves[n] = l.halves[n].data();
  kernels_.look(field_, layer, p, flows.data(), absolute(), squares(), halves);
  std::fill_n(l.fresh.begin() + std::ptrdiff_t(p), kLanes, std::uint8_t{1});
}

void DeltaCache::flip(int layer, std::size_t p) {
  std::array<PairFlows, HorizonState::kMaxLayers> flows;
  for (std::size_t k = std::size_t(layer); k < layers_.size(); ++k)
    flows[k - std::size_t(layer)] = pairs_of(layers_[k]);
  kernels_.flip(field_, layer, p, flows.data());
  // A flip changes errors within N - layer cells of its own, and reads them within N - its layer; of heights
  // and droplets it is less.
  const int layers = field_.horizon();
  for (int other = 0; other < layers; ++other) {
    const int reach = 2 * layers - layer - other;
    for (int y = -reach; y <= reach; ++y)
      std::fill_n(layers_[std::size_t(other)].fresh.begin() +
                      (std::ptrdiff_t(p) + y * std::ptrdiff_t(field_.row) - reach),
                  2 * reach + 1, std::uint8_t{0});
  }
}

}  // namespace firn::control::mpc
