// solve_strip() computes the optimal droplets of a strip of K rows by dynamic programming over its columns;
// the |error| of R rows counts.
#pragma once

#include <cstdint>
#include <vector>

#include "core/control/mpc/layer/cell_cost.h"
#include "core/control/mpc/layer/layer_problem.h"

namespace firn::control::mpc {

/// Cost of a forbidden pattern.
inline constexpr float kNever = 1e30f;

/// One column of a strip: heights that the patterns of its K cells add to the counted rows of the column
/// before (0), of its own (1) and of the next one (2).
template <int K, int R>
struct StripColumn {
  static constexpr int S = 1 << K;  ///< patterns; bit b is row b of the strip
  float error[R];                   ///< of the counted rows, with the strip empty
  float adds[3][R][S];
  float price[S];  ///< of a pattern by itself; kNever where a droplet may not be
};

/// Fills `adds` and sets `price` to 0 or kNever. `effects` are those of the column's K cells
/// (LayerProblem::effects, with stride nx * 9 between rows and nx between entries, from the column's first
/// entry); the first counted row is row `first_counted` of the strip (-1 = the row before it).
template <int K, int R>
void fill_column(StripColumn<K, R>& column, const float* effects, std::size_t nx, int first_counted,
                 int barred) {
  constexpr int S = StripColumn<K, R>::S;
  for (int s = 0; s < S; ++s) column.price[s] = s & barred ? kNever : 0.0f;
  for (int side = 0; side < 3; ++side)
    for (int r = 0; r < R; ++r) {
      float* adds = column.adds[side][r];
      adds[0] = 0.0f;
      for (int b = 0; b < K; ++b) {
        const int dy = first_counted + r - b;
        const float f = dy < -1 || dy > 1 ? 0.0f : effects[std::size_t(b * 9 + (dy + 1) * 3 + side) * nx];
        for (int s = 0; s < 1 << b; ++s) adds[s | 1 << b] = adds[s] + f;
      }
    }
}

/// A column beyond the grid: no droplets, no errors.
template <int K, int R>
void fill_edge(StripColumn<K, R>& column) {
  column = {};
  for (int s = 1; s < StripColumn<K, R>::S; ++s) column.price[s] = kNever;
}

/// The patterns of columns 1 .. nx that minimise the sum of the cells' costs and prices; columns[0] and
/// columns[nx + 1] are edges. `choice`: nx * 4^K bytes of workspace. @returns the minimum: float sums per
/// column, added up in double. Same bytes on every processor. Made for (K, K + 2), K = 1..6.
template <int K, int R>
double solve_strip(const StripColumn<K, R>* columns, int nx, const CellCost& cost, std::uint8_t* choice,
                   int* patterns);

}  // namespace firn::control::mpc
