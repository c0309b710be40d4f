// IlluminationKernels holds the loops over pixels and blocks that the illumination needs, with AVX2 where
// there is one. Both versions give the same bytes: no fused operations, sums in the same four lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/grid/avx2.h"

namespace firn::vision {

/// Squared contrast of all blocks that differ from the ground by more than a limit.
struct ContrastSums {
  double darker = 0.0, brighter = 0.0;
};

struct IlluminationKernels {
  /// Sums and extremes of the columns of four rows of pixels.
  void (*add_rows)(const std::uint16_t* row, std::size_t stride, int n, std::uint32_t* sum,
                   std::uint16_t* low, std::uint16_t* high);
  /// Whole blocks of a row of blocks, from the sums and extremes of its columns of pixels.
  void (*join_blocks)(int n, const std::uint32_t* sum, const std::uint16_t* low, const std::uint16_t* high,
                      float* mean, std::uint16_t* least, std::uint16_t* greatest);
  void (*extremes)(const std::int32_t* v, int n, std::int32_t& least, std::int32_t& largest);
  int (*count_up_to)(const std::int32_t* v, int n, std::int32_t level);
  void (*scale_by_16)(const float* v, int n, std::int32_t* to);
  /// ground = cubic in u with the coefficients k, clamped to [0, white].
  void (*cubic_row)(const double* u, int n, const std::array<double, 4>& k, double white, double least,
                    const float* mean, float* ground, ContrastSums& sums);
  /// ground += from + share * step
  void (*add_line)(const double* share, int n, double from, double step, float* ground);
  /// Is a block darker than its ground by more than a limit?
  bool (*any_deeper)(const float* ground, const float* mean, int n, float least);
};

/// @param wide with AVX2
const IlluminationKernels& illumination_kernels(bool wide = has_avx2());

}  // namespace firn::vision
