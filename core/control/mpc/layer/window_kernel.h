// Computes exact dynamic programming steps over a strip of K rows, cell by cell ("broken profile"). Cells are
// numbered column by column, p = x K + b. A state holds the droplets of the last 2 K + 2 cells, the latest in
// bit 0; with one more cell they hold the 3 x 3 window of the cell that lies one column and one row before
// it, so a step from cell to cell costs 2 * 4^(K + 1) additions, and every cost of a cell is a table of the
// 512 patterns of its window:
//   index = west * 64 + middle * 8 + east, where bit 0 of each column is the row of the latest cell, bits 1
//   and 2 those before.
// Single precision, eight lanes, element by element: the same bytes on every processor.
#pragma once

#include <array>
#include <cstddef>

#include "core/control/mpc/layer/cell_cost.h"

namespace firn::control::mpc {

/// Cost of a forbidden pattern.
inline constexpr float kBarred = 1e30f;

inline constexpr int kWindowPatterns = 512;
/// Patterns of the two latest rows of a window: west * 16 + middle * 4 + east, two bits each.
inline constexpr int kSharedPatterns = 64;

inline std::size_t profile_states(int rows) { return std::size_t{1} << (2 * rows + 2); }

/// `adds[3 column + bit]`: height that a droplet of the window adds to the middle cell, columns west, middle,
/// east.
void cost_table(float error_mm, const std::array<float, 9>& adds_mm, const CellCost& cost, float* table);
void zero_table(float* table);
void bar_latest(float* table);                                            ///< no droplet on the latest cell
void price_latest(float* table, float price);                             ///< of a droplet on the latest cell
void set_latest(float* table, bool drop);                                 ///< this droplet, no other
void add_shared(float* table, const float* shared_values, float factor);  ///< a function of kSharedPatterns

/// after[n] = min over states o that n can follow of before[o] + table. @param rows K, 3..6
void step_forward(int rows, const float* before, const float* table, float* after);
/// before[o] = min over states n that can follow o of table + after[n].
void step_backward(int rows, const float* after, const float* table, float* before);
/// Least before + table + after of each of the kSharedPatterns.
void min_by_pattern(int rows, const float* before, const float* table, const float* after, float* least);
/// Takes the least value off all. @returns it
float take_off_least(int rows, float* values);
/// The state before `state` (after one step) on the best path.
int state_before(int rows, const float* before, const float* table, int state);

}  // namespace firn::control::mpc
