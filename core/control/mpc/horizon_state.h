// HorizonState holds a plan of one to three layers, at most one droplet per cell, and its heights in single
// precision: annealing evaluates a droplet in well under a microsecond. Model and objective are those of
// HorizonObjective, which evaluates the result in double precision.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/plan_cost.h"

namespace firn::control::mpc {

/// How sums over the counted cells change by a droplet more or less: of |e|, of e, of e^2.
struct ObjectiveDeltas {
  double abs_error_mm = 0.0, first_mm = 0.0, second_mm2 = 0.0;
};

/// Heights before and after each layer, and the flows from the droplets of each layer to their neighbours, on
/// a grid padded by kMargin cells: a droplet of layer k changes heights within N - k cells, rows of eight
/// lanes at a time. A droplet on cell p gives a neighbour q clamp(gives_p + slope_p (H_p - H_q), 0, gives_p)
/// [Lu 2015, Eqs. (4), (5), (7)]; where there is none, gives = slope = 0.
///
/// With a price of height beside the part such a cell counts as one whose error is so large that |e| and e^2
/// are linear in its height: `counts` is then the price (kAbsolute), or the price times a layer's height over
/// twice that error (kSquare), so that sums over windows need no further terms.
struct HorizonState {
  static constexpr int kMaxLayers = 3, kMargin = 8;
  /// The large errors, that for |e| times the price where it is above 1. For |e| single precision must hold
  /// single droplets beside it (0.01 nm), and no plan may use it up; for e^2 neither matters, but the sum of
  /// e must not notice the cell.
  static constexpr float kOutside_mm = 0.1f, kOutsideSquare_mm = 100.0f;

  struct Ink {
    float drop_mm, gives_mm[2], slope[2];  // 0 sides, 1 corners
  };
  struct Layer {
    std::vector<float> height_mm;              // before it
    std::vector<float> gives_mm[2], slope[2];  // of the droplets present
    std::vector<std::uint8_t> drops, inks;     // 0 A, 1 B
  };

  /// @param materials per layer; none, or maps without cells: one ink. @pre horizon 1..kMaxLayers
  HorizonState(const Setup& setup, const HeightMap& height, std::span<const MaterialMap> materials,
               int horizon, const PlanCost& cost = {});

  std::size_t at(std::uint32_t cell) const {
    return std::size_t(cell / nx + kMargin) * row + cell % nx + kMargin;
  }
  int horizon() const { return int(layers.size()); }
  void set_plan(std::span<const DropletPattern> plan);   ///< its first horizon() layers
  void set_drops(std::span<const DropletPattern> plan);  ///< without the heights
  std::vector<DropletPattern> plan(const GridSpec& grid) const;
  void set_drop(int layer, std::size_t p, std::uint8_t drop);   ///< without the heights
  float outside_error_mm() const { return outside_error_mm_; }  ///< 0 without a price
  void refresh();  ///< heights after each layer, errors and sums anew

  std::uint32_t nx, ny;
  std::size_t row;
  Ink ink[2];
  std::vector<Layer> layers;
  std::vector<float> error_mm;                           // after the last layer; 0 where it does not count
  std::vector<float> counts;                             // 1 on the mask; beside it see above
  double cells = 0.0, first_mm = 0.0, second_mm2 = 0.0;  // number, sum and sum of squares of the errors
  double droplets = 0.0;                                 // in all layers
 private:
  void price_outside(const Setup& setup, const PlanCost& cost);
  bool on_part(std::size_t p) const { return part_.empty() || part_[p] != 0; }
  std::vector<float> target_;
  double outside_mm2() const;       // price of what the layers add beside the part; 0 but for kSquare
  std::vector<std::uint8_t> part_;  // 1 on the mask; empty without a price
  double outside_price_mm_ = 0.0;   // kSquare: of a mm beside the part, in the sum of squares
  float outside_error_mm_ = 0.0f;   // of cells beside the part before the first layer
};

}  // namespace firn::control::mpc
