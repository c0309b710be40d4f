// Lanes holds eight floats in one vector, for loops that are compiled once for any processor and once for
// AVX2, with the same bytes from both.
#pragma once

#include <cstdint>
#include <cstring>

#include "core/grid/avx2.h"

namespace firn::control::mpc {

using Lanes = float __attribute__((vector_size(32)));
using LaneMarks = std::int32_t __attribute__((vector_size(32)));

// Vectors go by reference: a function that returns one has no fixed ABI without AVX.
FIRN_INLINE void load(const float* from, Lanes& v) { std::memcpy(&v, from, sizeof v); }
FIRN_INLINE void store(const Lanes& v, float* to) { std::memcpy(to, &v, sizeof v); }

// out[l] = v[l + dx]; the lanes that wrap round are 0 here.
template <int DX>
FIRN_INLINE void shifted(const Lanes& v, Lanes& out) {
  if constexpr (DX == 0) out = v;
  if constexpr (DX == 1) out = __builtin_shufflevector(v, v, 1, 2, 3, 4, 5, 6, 7, 0);
  if constexpr (DX == -1) out = __builtin_shufflevector(v, v, 7, 0, 1, 2, 3, 4, 5, 6);
}

}  // namespace firn::control::mpc
