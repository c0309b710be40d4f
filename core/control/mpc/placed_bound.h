// PlacedBound computes a lower bound of all layers whose droplets lie in the centre of their cell or at a
// second place.
#pragma once

#include <string>
#include <vector>

#include "core/control/mpc/placed_objective.h"

namespace firn::control::mpc {

/// The decomposition of dual_decomposition.h for cells of up to three symbols (no droplet, centre, second
/// place), in double precision: one row of errors to a strip, so that a strip has three rows of droplets and
/// a column up to 27 patterns. For every cut between rows k and k + 1 and every column x the symbols of these
/// two rows in columns x - 1, x, x + 1 pay multipliers()[(k nx + x) 729 + pattern] in the strip above and
/// earn it in the strip below; pattern = 81 p(x - 1) + 9 p(x) + p(x + 1), p = symbol in row k + 3 times that
/// in row k + 1. Sweeps pass min-marginals on, down and up in turn.
///
/// A droplet that reaches beyond its eight neighbours is bounded too: an error c costs no more than its
/// distance from the interval that all farther droplets together could lessen it by. Prices beside the part
/// are the droplets' own.
class PlacedBound {
 public:
  static constexpr int kSymbols = 3, kPatterns = 27, kShared = 729;

  /// @param layer with two choices per cell at most; without droplets. kAbsolute or kSquare
  /// @throws std::invalid_argument: a cell has more choices
  explicit PlacedBound(const PlacedObjective& layer);

  /// One sweep over all strips. @returns the sum of their minima before each passed anything on, a bound up
  /// to rounding
  double sweep(bool down);
  const std::vector<double>& multipliers() const { return shared_; }

 private:
  struct Cell {
    bool part = false;
    int symbols = 1;
    double error_mm = 0.0, slack_mm = 0.0;  // target - height; what farther droplets may add at most
    double price[kSymbols] = {};
    double adds_mm[kSymbols][9] = {};  // index (dy + 1) 3 + dx + 1
  };
  struct Strip;
  const Cell* cell(int i, int j) const;
  double cost(const Cell& c, double adds_mm) const;
  double visit(int row, bool down);
  double* shared(int cut, int x) {
    return shared_.data() + (std::size_t(cut) * std::size_t(nx_) + std::size_t(x)) * std::size_t(kShared);
  }

  int nx_, ny_;
  bool square_;
  std::vector<Cell> cells_;
  std::vector<double> shared_;
};

/// Raises the bound of `empty`'s layers by MpcOptions::sweeps or until MpcOptions::gap, at most kSweepsForGap
/// sweeps.
/// @param value_mm of a known layer @returns "; after 12 sweeps, no layer is better by more than 0.050000 %",
/// of the sum over the part (of squares, if errors are squared)
std::string placed_reached(const PlacedObjective& empty, const MpcOptions& options, double value_mm);

/// The bound that given multipliers prove, of the sum over the part: from the setup itself, with nothing of
/// PlacedBound.
/// @param second see PlacedObjective @param multipliers of (ny - 1) nx windows, as PlacedBound has them
double certified_placed_bound(const Setup& setup, const HeightMap& height, const PlanCost& cost,
                              const OffsetMap& second, std::span<const double> multipliers);

}  // namespace firn::control::mpc
