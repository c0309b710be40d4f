// PlacedObjective computes the objective of a layer whose droplets have places inside their cells,
// incrementally.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/plan_cost.h"

namespace firn::control::mpc {

/// A layer of at most one droplet per cell, each at one of the places that its cell offers, after the rule of
/// deposition::OffsetChange: heights are linear in the droplets for given ground. A cell offers every place
/// of the table, with droplets of both sizes if there are two, where a kernel reaches beside the part, and
/// the centre alone elsewhere: inside the part a place decides nothing, and each height in a row of cells
/// costs a run of the stage.
///
/// Sums of |e| or e^2 over the part and the price of height beside it, as PlanCost has them, with alpha = 1.
class PlacedObjective {
 public:
  static constexpr int kNone = -1;  ///< no droplet

  /// @param inks of the droplets; without cells: ink A @pre heights finite everywhere
  /// @param second if given, each cell offers the centre and this place alone
  PlacedObjective(const Setup& setup, const HeightMap& height, const MaterialMap& inks, const PlanCost& cost,
                  const OffsetMap* second = nullptr);

  std::span<const std::uint32_t> cells() const { return cells_; }  ///< of the part, ascending
  /// Number of places that the n-th cell offers. A choice is one of 0 .. choices() - 1; choice 0 is the
  /// centre.
  int choices(std::size_t n) const { return first_[n + 1] - first_[n]; }
  int choice(std::size_t n) const { return chosen_[n]; }  ///< kNone or one of its places
  void choose(std::size_t n, int choice);
  /// Returns the change of the sum with a droplet on the n-th cell, which has none now.
  double rise_with(std::size_t n, int choice) const;

  /// Height that a choice adds to the cell (dx, dy) from the n-th, 0 where it does not count; what it costs
  /// beside.
  double adds_mm(std::size_t n, int choice, int dx, int dy) const {
    return effects_[std::size_t(first_[n] + choice)].mm[deposition::OffsetKernel::index(dx, dy)];
  }
  double price(std::size_t n, int choice) const { return effects_[std::size_t(first_[n] + choice)].price; }
  double error_mm(std::size_t n) const;  ///< target - height of the n-th cell with the droplets now
  const PlanCost& cost() const { return cost_; }

  /// alpha E of PlanCost for the sum, errors and all, of the droplets now.
  double value_mm() const;
  DropletPattern drops() const;
  OffsetMap offsets() const;  ///< without cells when all are in the centres
  const GridSpec& grid() const { return grid_; }

 private:
  static constexpr int kRadius = deposition::OffsetKernel::kRadius, kSide = deposition::OffsetKernel::kSide;
  struct Effect {
    std::array<double, std::size_t(deposition::OffsetKernel::kCells)> mm;  // on cells that count
    double price;                                                          // of the rest, and of the droplet
  };
  std::size_t padded(int i, int j) const {
    return std::size_t(j + kRadius) * row_ + std::size_t(i + kRadius);
  }
  Effect effect(const Setup& s, const HeightMap& height, int i, int j, const deposition::OffsetModel& model,
                int place) const;
  template <class Visit>
  void over(std::size_t n, int choice, const Visit& visit) const;

  GridSpec grid_;
  PlanCost cost_;
  double outside_price_, droplet_price_;  // in the sum
  std::size_t row_;
  std::vector<std::uint32_t> cells_;
  std::vector<std::size_t> corner_;  // padded, of each cell's 5 x 5
  std::vector<int> first_;           // of each cell in effects_, one more at the end
  std::vector<int> chosen_;
  std::vector<Effect> effects_;
  std::vector<std::uint8_t> places_;  // of each effect, an index of the table
  std::vector<double> error_;         // padded: target - height with the droplets; 0 where it does not count
  std::vector<std::uint8_t> counts_;  // padded
  double prices_ = 0.0;               // of the droplets now
};

}  // namespace firn::control::mpc
