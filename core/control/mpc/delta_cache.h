// DeltaCache holds the objective deltas of all single-droplet flips of a plan. They are computed for eight
// neighbouring cells at a time and stay valid until a flip nearby is accepted: annealing and descent reject
// most flips.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mpc/horizon_state.h"

namespace firn::control::mpc {

class DeltaCache {
 public:
  enum class Wanted : std::uint8_t { kAbsolute, kSquares, kBoth };  ///< sums of |e|; of e and e^2; all
  enum class Kernel : std::uint8_t { kWidest, kPortable };          ///< the same bytes from either

  /// @param field outlives the table; heights are changed by it alone from now on
  DeltaCache(HorizonState& field, Wanted wanted, Kernel kernel = Kernel::kWidest);

  const HorizonState& field() const { return field_; }
  /// The field's heights, errors and sums anew from its droplets, and nothing known of any flip.
  void refresh();
  /// Returns the deltas of flipping the droplet of a layer on a cell (HorizonState::at). Sums not wanted are
  /// 0. The bytes equal those of make_flip() and sums_of() of flip_kernel.h.
  ObjectiveDeltas sums(int layer, std::size_t p) {
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
    // Flows from cell p to its neighbours east, south west, south and south east, and back, at the present
    // heights.
    std::array<std::vector<float>, 4> gives, gets;
  };
  bool absolute() const { return wanted_ != Wanted::kSquares; }
  bool squares() const { return wanted_ != Wanted::kAbsolute; }
  void look(int layer, std::size_t p);  // at this cell and the seven after it

  struct Kernels;
  HorizonState& field_;
  Wanted wanted_;
  std::vector<Layer> layers_;
  const Kernels& kernels_;
};

}  // namespace firn::control::mpc
