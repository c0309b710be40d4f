// The inner loop of the height-change model: net flow along one link over one row of cells.
#pragma once

#include <cstddef>

namespace firn::deposition {

/// flow[i] = uc[i] clamp(w + slope (hc[i] - hn[i]), 0, w) - un[i] clamp(w - slope (hc[i] - hn[i]), 0, w): what the
/// droplets of cells c give to cells n, less what n's give to c. Then from[i] -= flow[i] and to[i] += flow[i]
/// (from and to may overlap). Same bytes whichever instruction set runs it: no fused operations, no reductions.
void flow_row(const double* hc, const double* hn, const double* uc, const double* un, double w_mm, double slope,
              double* flow, double* from, double* to, std::size_t n);

/// The portable version, against which tests compare the dispatched one.
void flow_row_portable(const double* hc, const double* hn, const double* uc, const double* un, double w_mm,
                       double slope, double* flow, double* from, double* to, std::size_t n);

}  // namespace firn::deposition
