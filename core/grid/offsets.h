// OffsetTable holds the places inside a cell at which a droplet may be aimed; OffsetMap holds the chosen
// place of each cell of a layer. Model, planner, scheduler, driver and audit number the places in the same
// way.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/grid/grid.h"
#include "core/options/option.h"

namespace firn {

/// The places of the table beside the centre. none: no others; x: along x alone, which costs no further run
/// of the stage; grid: along x and y, where each height y in a row of cells is a run of its own (a sub-row).
enum class OffsetKind : std::uint8_t { kNone, kX, kGrid };
inline constexpr std::array<std::string_view, 3> kOffsetKindWords{"none", "x", "grid"};
constexpr std::span<const std::string_view> words_of(OffsetKind) { return kOffsetKindWords; }

inline constexpr int kMaxPositions = 8;  ///< along an axis
inline constexpr int kMaxPlaces = 128;   ///< of a table: an index fits into a message's byte

struct OffsetOptions {
  OffsetKind offsets = OffsetKind::kNone;
  int positions_x = 4, positions_y = 4;
  double small_share = 0.0;
  bool operator==(const OffsetOptions&) const = default;
};
inline constexpr OptionTable kOffsetOptions{
    Option{"offsets", &OffsetOptions::offsets, "", Range{},
           "where in its cell a droplet may land: none = in the middle; x = at positions_x places along x; "
           "grid = at "
           "positions_x times positions_y places, each height y being a run of the stage of its own"},
    Option{"positions_x", &OffsetOptions::positions_x, "", within(1, kMaxPositions),
           "places along x, equally far apart and symmetric about the middle, which always belongs to them"},
    Option{"positions_y", &OffsetOptions::positions_y, "", within(1, kMaxPositions), "grid: places along y"},
    Option{
        "small_share", &OffsetOptions::small_share, "", within(0, 0.95),
        "volume of a second size of droplet (jet.small_dwell_v) by that of the first: each place has both; "
        "0 = there is one size"},
};

/// A place inside a cell, in shares of the pitch from its centre, above -0.5 and below 0.5.
struct Offset {
  double x = 0.0, y = 0.0;
  bool operator==(const Offset&) const = default;
};

/// The places by index. Index 0 is the centre; the others follow row by row, y before x, each ascending:
/// (2k + 1 - n) / 2n for k = 0 .. n-1 along an axis of n places. So 4 places along x are 0, -0.375,
/// -0.125, 0.125, 0.375 (five entries), 3 are 0, -1/3, 1/3. With a second size of droplet all of them follow
/// once more, for small droplets: index n + places() is place n with a small one.
class OffsetTable {
 public:
  OffsetTable() : OffsetTable(OffsetOptions{}) {}
  /// @throws std::invalid_argument naming the option out of its range, or more than kMaxPlaces
  explicit OffsetTable(const OffsetOptions& options);

  int size() const { return int(offsets_.size()); }
  int places() const { return places_; }  ///< of one size of droplet
  bool small(int index) const { return index >= places_; }
  /// Volume of a place's droplets by that of the first size, as the options say.
  double share(int index) const { return small(index) ? small_share_ : 1.0; }
  /// Returns the index of the same place with a droplet of the first size.
  int place(int index) const { return index % places_; }
  /// @pre 0 <= index < size()
  const Offset& operator[](int index) const { return offsets_[std::size_t(index)]; }
  /// Returns the index of the place nearest to (x, y), in shares of the pitch, with a droplet of the first
  /// size.
  int nearest(Offset place) const;
  /// Number of the sub-row of a place, by ascending y; 0 <= sub_row() < sub_rows().
  int sub_row(int index) const { return sub_row_[std::size_t(index)]; }
  int sub_rows() const { return sub_rows_; }
  bool operator==(const OffsetTable&) const = default;

 private:
  std::vector<Offset> offsets_;
  std::vector<int> sub_row_;
  int sub_rows_ = 1, places_ = 1;
  double small_share_ = 0.0;
};

/// The place of each cell's droplets in one layer, as an index of an OffsetTable. Without cells: all in the
/// centre.
struct OffsetMap : Grid<std::uint8_t> {
  using Grid::Grid;
  int of(std::size_t cell) const { return cells.empty() ? 0 : int(cells[cell]); }
};

/// Places inside the cells at which the droplets of a layer, or of a pass, are aimed. Default: the centres,
/// at any distance.
struct Placement {
  OffsetTable table = {};
  OffsetMap map = {};
  /// Two droplets of one run of the stage are at least this far apart: nearer ones are in a second run over
  /// the same sub-row. 0: one run, whatever the distances.
  double apart_mm = 0.0;

  Offset of(std::size_t cell) const { return table[map.of(cell)]; }
  bool small(std::size_t cell) const { return table.small(map.of(cell)); }
};
/// @throws std::invalid_argument naming the first cell: a map of another size than the grid's, an index
/// beyond the table
void check(const Placement& placement, const GridSpec& grid);

/// All that lies between a stage's reading and the point on the part that a droplet fired there reaches.
struct Aim {
  double nozzle_x_mm = 0.0,
         nozzle_y_mm = 0.0;  ///< of the firing nozzle, beyond that of the first: jet_b.offset
  double lead_mm = 0.0;      ///< way of the stage while the droplet falls, by its flight in the strobe
};

/// The stage's own reading at the moment when the droplet of a cell is fired.
struct StagePlace {
  double x_mm = 0.0, y_mm = 0.0;
};
/// The one sum of all that moves a droplet: cell, place inside it, nozzle and lead.
StagePlace stage_place(const GridSpec& grid, int i, int j, Offset offset, const Aim& aim,
                       bool towards_plus_x);

/// The point of the part that a droplet reaches which is fired there: the inverse sum.
StagePlace part_place(StagePlace stage, const Aim& aim, bool towards_plus_x);

}  // namespace firn
