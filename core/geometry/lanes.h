// Lanes2 and Lanes4 hold two doubles or four integers for SIMD comparisons. Without SSE2 the comparisons take
// the lanes one by one.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/geometry/region.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace firn::geometry {

using Lanes2 = double __attribute__((vector_size(16)));
using Lanes4 = std::int32_t __attribute__((vector_size(16)));

/// Returns x and y of a point and of the next one.
inline Lanes4 two_points(const Point* p) {
  static_assert(sizeof(Point) == 8);
  Lanes4 lanes;
  std::memcpy(&lanes, p, sizeof lanes);
  return lanes;
}

/// The result of a comparison of Lanes2: all bits of a lane are set where it holds.
using Held2 = decltype(Lanes2{} < Lanes2{});

/// Returns one bit for each lane in which a comparison holds: 1 and 2.
inline int lanes_of(Held2 held) {
#ifdef __SSE2__
  return _mm_movemask_pd(std::bit_cast<__m128d>(held));
#else
  return int(held[0] & 1) | int(held[1] & 2);
#endif
}

/// Returns one bit for each negative lane.
inline unsigned signs(Lanes4 lanes) {
#ifdef __SSE2__
  return unsigned(_mm_movemask_ps(std::bit_cast<__m128>(lanes)));
#else
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= unsigned(lanes[i] < 0) << i;
  return bits;
#endif
}

}  // namespace firn::geometry
