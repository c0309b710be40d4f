// The errors of a LayerProblem by whole rows, and droplet by droplet where two inks meet.
#include "core/control/mpc/layer/layer_rows.h"

#include <cmath>

#include "core/control/mpc/layer/layer_problem.h"

namespace firn::control::mpc {

RowCells LayerProblem::row_at(int j) const {
  const std::size_t p = at(0, j);
  return {height_.data() + p, bare_.data() + p,  error_.data() + p,
          counts_.data() + p, drops_.data() + p, std::ptrdiff_t(row_)};
}

RowInk LayerProblem::row_ink() const {
  const Ink& ink = inks_[0];
  RowInk out{ink.drop_mm, {ink.w_mm[1], ink.w_mm[0]}, {ink.slope[1], ink.slope[0]}, {}};
  if (height_.front() < 0.0f) {
    out.beyond_mm[0] = out.w_mm[0];
    out.beyond_mm[1] = out.w_mm[1];
  }
  return out;
}

void LayerProblem::refresh() {
  if (inks_of_.empty()) {
    layer_row_kernels().back().errors(row_at(0), row_ink(), std::size_t(nx_), std::size_t(ny_),
                                      error_.data() + at(0, 0));
    return;
  }
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
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

}  // namespace firn::control::mpc
