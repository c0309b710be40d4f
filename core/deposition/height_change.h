// HeightChange computes the height change of one layer of droplets on an uneven surface: the heights that a
// droplet adds to its own cell and to its neighbours [Lu 2015, Eqs. (3)-(5)]. deposit_additive() computes the
// additive baseline [Eq. (2)].
//
// A droplet on cell c raises each neighbour n by w sat_{h1+w}(H_c - H_n), w = h2 at a side and h3 at a
// corner, and its own cell by h1 plus the part that the neighbours do not take. So each droplet adds exactly
// h1 + 4 h2 + 4 h3 (in cell heights), and dH is linear in the droplets for given H. The errata's readings: in
// (3) U and dH belong to the same layer (H_{k+1} = H_k + dH(H_k, U_k)); the border is an option (the paper
// does not define it).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/grid/grid.h"
#include "core/options/option.h"

namespace firn::deposition {

/// Height change constants of one ink [Lu 2015, Table I]; defaults are the paper's.
struct DropletModel {
  double h1_mm = 4.4e-3;  ///< centre
  double h2_mm = 0.6e-3;  ///< each of four side neighbours
  double h3_mm = 0.2e-3;  ///< each of four corner neighbours

  /// Height that one droplet adds over all cells = height of a full layer far from any edge.
  double layer_height_mm() const { return h1_mm + 4.0 * h2_mm + 4.0 * h3_mm; }
  /// Sum of the squares of the heights that one droplet adds to the cells.
  double sum_of_squares_mm2() const { return h1_mm * h1_mm + 4.0 * h2_mm * h2_mm + 4.0 * h3_mm * h3_mm; }
  DropletModel times(double factor) const { return {factor * h1_mm, factor * h2_mm, factor * h3_mm}; }
  bool operator==(const DropletModel&) const = default;
};
inline constexpr Option kModelH1{"h1_mm", &DropletModel::h1_mm, "mm", above(0, 10),
                                 "height under a droplet [Lu 2015, Table I]"};
inline constexpr Option kModelH2{"h2_mm", &DropletModel::h2_mm, "mm", within(0, 10),
                                 "height beside a droplet, per edge"};
inline constexpr Option kModelH3{"h3_mm", &DropletModel::h3_mm, "mm", within(0, 10),
                                 "height beside a droplet, per corner"};
inline constexpr OptionTable kDropletModel{kModelH1, kModelH2, kModelH3};
/// @throws std::invalid_argument naming the constant that is out of its range.
void check(const DropletModel& model);

/// Boundary condition at the grid's border. kLose: infinitely low ground, sat = 1, its share is lost (the
/// reading that reproduces section III-C). kKeep: a wall, sat = 0, so the volume on the grid is conserved.
enum class Border : std::uint8_t { kLose, kKeep };

/// sat_a(b) of Eq. (5): 1 for b >= 0, falling to 0 at b = -a. @pre a > 0
inline double sat(double a, double b) { return b >= 0.0 ? 1.0 : (b <= -a ? 0.0 : 1.0 + b / a); }

/// A droplet's weights by neighbour class: (1,0), (1,1), (2,0), (2,1), (2,2), ... Radius 1 is Lu's (h2, h3);
/// his remark in III-A asks for more.
template <int Radius>
struct Stencil {
  static_assert(Radius >= 1 && Radius <= 4);
  static constexpr int kClasses = (Radius + 1) * (Radius + 2) / 2 - 1;
  double centre_mm = 0.0;
  std::array<double, kClasses> ring_mm{};

  static constexpr int class_of(int dx, int dy) {
    const int a = dx < 0 ? -dx : dx, b = dy < 0 ? -dy : dy;
    const int p = a > b ? a : b, q = a > b ? b : a;
    return p * (p + 1) / 2 + q - 1;
  }
  double at(int dx, int dy) const {
    return dx == 0 && dy == 0 ? centre_mm : ring_mm[std::size_t(class_of(dx, dy))];
  }
  /// Height that one droplet adds over all cells.
  double drop_height_mm() const;
};
Stencil<1> stencil_of(const DropletModel& model);

/// One neighbour link: a droplet raises the cell at (dx, dy) by clamp(w + slope * (H_c - H_n), 0, w), which
/// is w sat_{h1+w}(H_c - H_n) with slope = w / (h1 + w).
struct Link {
  int dx = 0;
  int dy = 0;
  double w_mm = 0.0;
  double slope = 0.0;
  double spread_mm(double drop_mm) const {
    double x = w_mm + slope * drop_mm;
    x = x < w_mm ? x : w_mm;
    return x > 0.0 ? x : 0.0;
  }
};
/// All links of a droplet, row by row in (dy, dx).
template <int Radius>
std::vector<Link> links_of(const Stencil<Radius>& stencil);

/// Where the height of a step went, in cell heights (multiply by the cell's area for mm^3).
struct Ledger {
  std::int64_t drops = 0;
  double deposited_mm = 0.0;  ///< sum over droplets of drop_height_mm
  double lost_mm = 0.0;       ///< the share that went over the border; sum dH + lost = deposited
  Ledger& operator+=(const Ledger& o) {
    drops += o.drops;
    deposited_mm += o.deposited_mm;
    lost_mm += o.lost_mm;
    return *this;
  }
};

/// The model on one grid, with its workspace: steps allocate nothing.
template <int Radius>
class HeightChange {
 public:
  /// @throws std::invalid_argument: grid out of range; weights negative or not finite, centre not above 0.
  HeightChange(const GridSpec& grid, const Stencil<Radius>& stencil, Border border);

  /// Adds `drops` to `height`: a cell with n drops gets them in n passes, pass p (0-based) being one step of
  /// Eq. (4) on the height that pass p - 1 left, over the cells with more than p drops.
  /// @throws std::invalid_argument before anything is changed: sizes differ from the grid, a height is NaN or
  /// infinite (the model needs every cell: fill unmeasured cells first).
  Ledger deposit(HeightMap& height, const DropletPattern& drops);

  /// One pass (cells with more than `pass` drops). @pre heights finite, sizes equal to the grid's
  Ledger step(double* height_mm, const std::uint8_t* drops, int pass);

  /// As step(), every droplet with its own weights: `stencils[c]` belongs to the droplet on cell c (two
  /// materials [Eqs. (6), (7), with the errata's corrections], droplet size variation).
  Ledger step(double* height_mm, const std::uint8_t* drops, int pass,
              std::span<const Stencil<Radius>> stencils);

  const Ledger& total() const { return total_; }  ///< since construction
  const GridSpec& grid() const { return grid_; }
  const Stencil<Radius>& stencil() const { return stencil_; }
  Border border() const { return border_; }

 private:
  template <class Flow>
  Ledger run(double* height_mm, const std::uint8_t* drops, int pass, const Flow& flow);
  double* row_of(std::vector<double>& ring, int j) {
    return ring.data() + std::size_t(j % (Radius + 1)) * width_;
  }

  GridSpec grid_;
  Stencil<Radius> stencil_;
  Border border_;
  std::size_t width_;
  std::vector<Link> forward_;   // one link of each opposite pair: dy > 0, or dy = 0 and dx > 0
  std::vector<double> drops_;   // rings of Radius + 1 rows: droplets as 0.0 / 1.0,
  std::vector<double> change_;  // height change so far,
  std::vector<double> flow_;    // flows of one link over one row
  Ledger total_;
};
extern template class HeightChange<1>;
extern template class HeightChange<2>;

/// The traditional baseline: Eq. (2), every droplet adds h1, h2, h3 at any heights; shares beyond the grid
/// are lost. n drops add n times as much. @throws std::invalid_argument when sizes differ.
Ledger deposit_additive(HeightMap& height, const DropletPattern& drops, const DropletModel& model);

/// @throws std::invalid_argument naming the first cell that is NaN or infinite.
void check_finite(const HeightMap& height, const char* what);

}  // namespace firn::deposition
