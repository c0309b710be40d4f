// HorizonObjective computes the objective of Eq. (8) [Lu 2015] over a horizon, incrementally: evaluating a
// single-droplet change costs its neighbourhood, not the grid.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/plan_cost.h"
#include "core/deposition/height_change.h"

namespace firn::control::mpc {

/// One droplet more (+1) or less (-1) on a cell in a layer of the horizon (0-based).
struct Move {
  int layer = 0;
  std::uint32_t cell = 0;
  int change = 0;
  Move undone() const { return {layer, cell, -change}; }
};

/// Predicted heights of N layers of up to `max_drops` passes each, and the objective of the last.
/// A layer of n-droplet cells is n steps of Eq. (4), so the horizon is a chain of N * max_drops steps; a move
/// changes one droplet of one step, whose effect on that step's result is 3 x 3 cells, exact and linear (dH
/// is linear in U); every later step widens the changed window by one cell. The running sums drift by
/// rounding; refresh() recomputes everything, and is to be called before a result is trusted.
class HorizonObjective {
 public:
  /// @param price_mm2 of a droplet, @param mean_weight and @param outside_price see PlanCost
  HorizonObjective(const Setup& setup, int horizon, int max_drops, ErrorKind error = ErrorKind::kAbsolute,
                   double price_mm2 = 0.0, double mean_weight = 0.0, double outside_price = 0.0);

  /// The surface to print on (finite everywhere) and the weight of Eq. (8). A plan must follow.
  /// @param materials ink of each cell in each layer of the horizon; none: one ink
  void set_surface(const HeightMap& height, double alpha, std::span<const MaterialMap> materials = {});
  /// The plan to start from, one pattern per layer of the horizon.
  void set_plan(std::span<const DropletPattern> plan);

  double value_mm() const { return value_mm_; }
  bool allowed(const Move& move) const;  ///< stays within 0..max_drops
  double gain_mm(const Move& move);      ///< new objective - present one. @pre allowed
  void apply(const Move& move);          ///< @pre allowed
  void refresh();                        ///< all heights and sums anew from the droplets

  const DropletPattern& layer(int n) const { return plan_[std::size_t(n)]; }
  std::span<const std::uint32_t> part_cells() const { return part_; }  ///< cells of the mask, ascending
  /// Cells whose droplets a search may change, ascending: those of the mask, or of move_only().
  std::span<const std::uint32_t> moved_cells() const { return only_.empty() ? part_ : only_; }
  /// Leaves the droplets of all other cells as they are. @pre of the same grid, some cell of the mask
  void move_only(const Mask& cells);
  /// Moves on cells further apart than this, in x or in y, do not change each other's effect on any height.
  int reach() const { return 2 * int(drops_.size()); }
  const GridSpec& grid() const { return grid_; }
  double alpha() const { return cost_.alpha; }
  ErrorKind error() const { return cost_.error; }
  const PlanCost& cost() const { return cost_; }
  int horizon() const { return int(plan_.size()); }
  int max_drops() const { return max_drops_; }

 private:
  struct Sums {
    double abs_error = 0.0, first = 0.0, second = 0.0, droplets = 0.0, outside = 0.0;
  };
  double square_of(const Sums& sums) const;  // mean of the squared errors and the droplets' price
  std::size_t padded(std::uint32_t cell) const { return padded_[cell]; }
  std::size_t step_of(const Move& move) const;  // the step whose droplet a move sets or clears
  template <class Visit>
  void first_change(const Move& move, std::size_t step, const Visit& visit) const;  // visit(cell, change)
  // Leaves the changes after the last step in delta_, keeps those before it if `keep`. Returns the radius.
  int propagate(const Move& move, std::size_t step, bool keep);
  // delta_: change before the step -> change after it.
  void widen(std::size_t step, std::size_t centre, int radius, bool keep);
  template <class Visit>
  void window(std::size_t centre, int radius, const Visit& visit) const;
  void add(std::size_t cell, double delta, Sums& sums) const;
  void note_height(std::size_t cell);
  double gain_of(const Sums& change) const;
  double single_step_gain(std::uint32_t cell, double sign) const;
  void fill_table();
  void set_materials(std::span<const MaterialMap> materials);
  /// Adds the layer of a step to the model. Returns the sum of heights [mm] that leaves the border.
  double step_model(std::size_t step, const DropletPattern& layer, int pass);
  void store(const HeightMap& height, std::size_t step);

  GridSpec grid_;
  deposition::HeightChange<1> model_;  // for refresh()
  HeightMap surface_, predicted_;
  int max_drops_;
  PlanCost cost_;
  // Flow links of a droplet of one ink to its neighbours.
  struct Ink {
    double drop_height_mm = 0.0;
    std::vector<deposition::Link> links;  // without those of weight 0
    std::vector<std::ptrdiff_t> offsets;  // of the links, on the padded grid
    deposition::Stencil<1> stencil;
  };
  const Ink& ink_at(std::size_t step, std::size_t padded_cell) const {
    return inks_[materials_.empty() ? 0 : materials_[step][padded_cell]];
  }
  std::array<Ink, 2> inks_;                           // A, B
  std::vector<std::vector<std::uint8_t>> materials_;  // per step, padded: 0 A, 1 B; empty with one ink
  std::vector<deposition::Stencil<1>> stencils_;      // scratch: of one step's droplets
  std::size_t row_;                                   // padded row length
  double count_ = 0.0;                                // cells of the mask,
  double per_cell_ = 0.0;                             // and 1 / count_
  double reference_mm_ = 0.0;                         // heights are summed relative to this
  double variance_ = 0.0;                             // of the last heights on the mask,
  double root_ = 0.0;                                 // and its root
  double outside_mm_ = 0.0;                           // price of a mm beside the part, in the sum of squares
  double value_mm_ = 0.0;
  Sums sums_;
  std::vector<std::uint32_t> part_, only_;
  std::vector<std::uint32_t> padded_;             // index on the padded grid of each cell
  std::vector<double> target_;                    // padded
  std::vector<std::uint8_t> counts_;              // padded: 1 on the mask
  std::vector<std::vector<double>> height_;       // padded, before step 0 .. after the last
  std::vector<std::vector<std::uint8_t>> drops_;  // padded, per step
  std::vector<double> delta_, next_;              // padded scratch, zero between calls
  std::vector<DropletPattern> plan_;
  // For a horizon of one step (N = 1, one drop), where the surface under the droplets never changes: per cell
  // of the grid the heights that one droplet adds to its nine cells (0 off the mask), their sum and sum of
  // squares. Three rows of four, the fourth 0, so that rows fill vector registers.
  struct Shares {
    double mm[12], sum_mm, square_mm2, outside_mm;
  };
  std::vector<Shares> table_;
  std::vector<double> error_, deviation_;  // padded, 0 off the mask: target - height,
                                           // its negative - reference; one more cell at the end
};

}  // namespace firn::control::mpc
