// What every single flip would do to the sums of a plan, computed eight neighbouring cells at a time and kept
// until something near changes: most flips that annealing and descent try are refused, and change nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mpc/plan_field.h"

namespace firn::control::mpc {

class FlipTable {
 public:
  enum class Wanted : std::uint8_t { kAbsolute, kSquares, kBoth };  ///< sums of |e|; of e and e^2; all
  enum class Kernel : std::uint8_t { kWidest, kPortable };          ///< the same bytes from either

  /// @param field outlives the table; heights are changed by it alone from now on
  FlipTable(PlanField& field, Wanted wanted, Kernel kernel = Kernel::kWidest);

  const PlanField& field() const { return field_; }
  /// The field's heights, errors and sums anew from its droplets, and nothing known of any flip.
  void refresh();
  /// Of the droplet of a layer on a cell (PlanField::at) more or less; the sums not wanted are 0.
  /// Bit for bit what make_flip() and sums_of() of flip_kernel.h give.
  FlipSums sums(int layer, std::size_t p) {
    Layer& l = layers_[std::size_t(layer)];
    if (!l.fresh[p]) look(layer, p);
    const auto sum = [&l, p](std::size_t n) {
      return double(l.halves[2 * n][p]) + double(l.halves[2 * n + 1][p]);
    };
    return {absolute() ? sum(0) : 0.0, squares() ? sum(1) : 0.0, squares() ? sum(2) : 0.0};
  }
  void flip(int layer, std::size_t p);  ///< does it

 private:
  struct Layer {
    std::vector<std::uint8_t> fresh;
    std::array<std::vector<float>, 6> halves;  // of each sum, western columns of the window and eastern
    // What cell p would give to its neighbours east, south west, south and south east, and get from them, as
    // they are.
    std::array<std::vector<float>, 4> gives, gets;
  };
  bool absolute() const { return wanted_ != Wanted::kSquares; }
  bool squares() const { return wanted_ != Wanted::kAbsolute; }
  void look(int layer, std::size_t p);  // at this cell and the seven after it

  struct Kernels;
  PlanField& field_;
  Wanted wanted_;
  std::vector<Layer> layers_;
  const Kernels& kernels_;
};

}  // namespace firn::control::mpc
