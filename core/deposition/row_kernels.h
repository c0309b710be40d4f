// RowKernels computes the inner loops of the height-change model over one row of cells. Same bytes on every
// instruction set: element by element, no fused operations, no reductions of floating point.
#pragma once

#include <cstddef>
#include <cstdint>

namespace firn::deposition {

struct RowKernels {
  /// flow[i] = uc[i] clamp(w + slope (hc[i] - hn[i]), 0, w) - un[i] clamp(w - slope (hc[i] - hn[i]), 0, w):
  /// the flow from the droplets of cells c to cells n, less the flow from those of n to c. Then from[i] -=
  /// flow[i] and to[i] += flow[i] (from and to may overlap each other, nothing else).
  void (*flow)(const double* hc, const double* hn, const double* uc, const double* un, double w_mm,
               double slope, double* flow, double* from, double* to, std::size_t n);
  /// u[i] = drops[i] > pass ? 1 : 0. Returns their number.
  std::int64_t (*load)(const std::uint8_t* drops, int pass, double* u, std::size_t n);
  /// h[i] += u[i] * drop_mm + change[i]; change[i] = 0.
  void (*settle)(double* h, const double* u, double drop_mm, double* change, std::size_t n);
};

/// The widest that this processor has.
const RowKernels& row_kernels();
/// Those without machine-specific instructions, against which tests compare.
const RowKernels& portable_row_kernels();

}  // namespace firn::deposition
