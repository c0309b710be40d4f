// Computes the height changes that one droplet more or less causes in all later layers, rows of eight lanes
// at a time. For the inside of loops that are compiled once for any processor and once for AVX2; the same
// bytes from both.
#pragma once

#include <cmath>

#include "core/control/mpc/horizon_state.h"
#include "core/control/mpc/layer/lanes.h"

namespace firn::control::mpc {

/// The changes that one droplet makes: rows -3..3 about its cell, columns -4..3.
struct Flip {
  static constexpr int kRows = 7, kMiddle = 3, kLane = 4;
  Lanes change[HorizonState::kMaxLayers][kRows];  // of the heights after layer, after the next, ...
  float sign = 0.0f;
};

// clamp(gives + lean, 0, gives)
FIRN_INLINE void given(const Lanes& gives, const Lanes& lean, Lanes& out) {
  const Lanes x = gives + lean, y = x < gives ? x : gives;
  out = y > 0.0f ? y : Lanes{};
}

// Adds to `next` the changes of the flows between the pairs of cells (p, p + (DX, DY)), p in row y.
template <int DX, int DY>
FIRN_INLINE void exchange(const HorizonState& f, const HorizonState::Layer& l, std::size_t centre, int y,
                          const Lanes* d, Lanes* next) {
  constexpr int corner = DX != 0 && DY != 0;
  const std::ptrdiff_t p = std::ptrdiff_t(centre) + y * std::ptrdiff_t(f.row) - Flip::kLane,
                       q = p + DY * std::ptrdiff_t(f.row) + DX;
  Lanes hp, hq, give_p, give_q, lean_p, lean_q, dq;
  load(l.height_mm.data() + p, hp);
  load(l.height_mm.data() + q, hq);
  load(l.gives_mm[corner].data() + p, give_p);
  load(l.gives_mm[corner].data() + q, give_q);
  load(l.slope[corner].data() + p, lean_p);
  load(l.slope[corner].data() + q, lean_q);
  shifted<DX>(d[Flip::kMiddle + y + DY], dq);
  const Lanes drop = hp - hq, drop_now = drop + (d[Flip::kMiddle + y] - dq);
  Lanes out, back, out_now, back_now, returned;
  given(give_p, lean_p * drop, out);
  given(give_q, -(lean_q * drop), back);
  given(give_p, lean_p * drop_now, out_now);
  given(give_q, -(lean_q * drop_now), back_now);
  const Lanes change = (out_now - out) - (back_now - back);
  shifted<-DX>(change, returned);
  next[Flip::kMiddle + y] -= change;
  next[Flip::kMiddle + y + DY] += returned;
}

// Changes before a layer, within R cells -> changes after it, within R + 1.
template <int R>
FIRN_INLINE void widen(const HorizonState& f, const HorizonState::Layer& l, std::size_t centre,
                       const Lanes* d, Lanes* next) {
  for (int y = 0; y < Flip::kRows; ++y) next[y] = d[y];
  for (int y = -R; y <= R; ++y) exchange<1, 0>(f, l, centre, y, d, next);
  for (int y = -R - 1; y <= R; ++y) {
    exchange<-1, 1>(f, l, centre, y, d, next);
    exchange<0, 1>(f, l, centre, y, d, next);
    exchange<1, 1>(f, l, centre, y, d, next);
  }
}

FIRN_INLINE void first_change(const HorizonState& f, int layer, std::size_t p, Flip& flip) {
  const HorizonState::Layer& l = f.layers[std::size_t(layer)];
  const HorizonState::Ink& ink = f.ink[l.inks[p]];
  float near[9], own = ink.drop_mm;
  for (int q = 0; q < 9; ++q) {
    if (q == 4) continue;
    const int corner = q % 2 == 0;
    const float gives = ink.gives_mm[corner];
    const float* h = l.height_mm.data();
    float x =
        gives +
        ink.slope[corner] *
            (h[p] - h[std::size_t(std::ptrdiff_t(p) + (q / 3 - 1) * std::ptrdiff_t(f.row) + q % 3 - 1)]);
    x = x < gives ? x : gives;
    x = x > 0.0f ? x : 0.0f;
    near[q] = flip.sign * x;
    own -= x;
  }
  near[4] = flip.sign * own;
  Lanes* d = flip.change[0];
  for (int y = 0; y < Flip::kRows; ++y) d[y] = Lanes{};
  for (int y = 0; y < 3; ++y)
    d[Flip::kMiddle - 1 + y] = Lanes{0, 0, 0, near[3 * y], near[3 * y + 1], near[3 * y + 2], 0, 0};
}

// Height changes by a flip of the droplet on p, up to the last layer.
FIRN_INLINE void make_flip(const HorizonState& f, int layer, std::size_t p, Flip& flip) {
  flip.sign = f.layers[std::size_t(layer)].drops[p] ? -1.0f : 1.0f;
  first_change(f, layer, p, flip);
  const int later = f.horizon() - 1 - layer;
  if (later >= 1) widen<1>(f, f.layers[std::size_t(layer + 1)], p, flip.change[0], flip.change[1]);
  if (later >= 2) widen<2>(f, f.layers[std::size_t(layer + 2)], p, flip.change[1], flip.change[2]);
}

FIRN_INLINE double sum_of(const Lanes& v) {
  return double((v[0] + v[1]) + (v[2] + v[3])) + double((v[4] + v[5]) + (v[6] + v[7]));
}

FIRN_INLINE void sums_of(const HorizonState& f, int layer, std::size_t p, const Flip& flip,
                         ObjectiveDeltas& s) {
  const int later = f.horizon() - 1 - layer, reach = later + 1;
  Lanes worse = {}, first = {}, second = {};
  for (int y = -reach; y <= reach; ++y) {
    const std::ptrdiff_t from = std::ptrdiff_t(p) + y * std::ptrdiff_t(f.row) - Flip::kLane;
    Lanes e, counts;
    load(f.error_mm.data() + from, e);
    load(f.counts.data() + from, counts);
    const Lanes d = counts * flip.change[later][Flip::kMiddle + y], now = e + d;
    worse += Lanes(LaneMarks(now) & 0x7fffffff) - Lanes(LaneMarks(e) & 0x7fffffff);
    first += d;
    second += d * (e + now);
  }
  s = {sum_of(worse), sum_of(first), sum_of(second)};
}

FIRN_INLINE void keep_flip(HorizonState& f, int layer, std::size_t p, const Flip& flip,
                           const ObjectiveDeltas& s) {
  f.set_drop(layer, p, flip.sign > 0.0f);
  for (int k = layer; k < f.horizon(); ++k) {
    const bool last = k + 1 == f.horizon();
    float* to = last ? f.error_mm.data() : f.layers[std::size_t(k + 1)].height_mm.data();
    const int reach = k - layer + 1;
    for (int y = -reach; y <= reach; ++y) {
      const std::ptrdiff_t from = std::ptrdiff_t(p) + y * std::ptrdiff_t(f.row) - Flip::kLane;
      Lanes v, d = flip.change[k - layer][Flip::kMiddle + y];
      load(to + from, v);
      if (last) {
        Lanes counts;
        load(f.counts.data() + from, counts);
        d *= counts;
      }
      v += d;
      store(v, to + from);
    }
  }
  f.droplets += double(flip.sign);
  f.first_mm += s.first_mm;
  f.second_mm2 += s.second_mm2;
}

}  // namespace firn::control::mpc
