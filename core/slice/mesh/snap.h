// to_grid() computes grid coordinates from floating point, identically wherever it is used.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/slice/mesh/placement.h"

namespace firn::slice {

/// Added to a number below 2^31, this leaves the nearest integer (halves to even) in the low bits of the sum.
inline constexpr double kRounding = 6755399441055744.0;  // 1.5 x 2^52

inline std::int32_t to_grid(double v) { return std::int32_t(std::bit_cast<std::int64_t>(v + kRounding)); }

inline Vertex to_grid(const Affine& a, const Corner& p) {
  const double x = p[0], y = p[1], z = p[2];
  const auto& m = a.matrix;
  return {to_grid((m[0] * x + m[1] * y + m[2] * z) + a.shift[0]),
          to_grid((m[3] * x + m[4] * y + m[5] * z) + a.shift[1]),
          to_grid((m[6] * x + m[7] * y + m[8] * z) + a.shift[2])};
}

inline bool finite(const Corner& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}
inline bool finite(const std::array<Corner, 3>& f) { return finite(f[0]) && finite(f[1]) && finite(f[2]); }

}  // namespace firn::slice
