// NearestStart finds the nearest start point among the lines of a layer that are not yet printed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/rtree.h"

namespace firn::slice {

/// The index is an R-tree (rtree.h) of the start points in Morton order [Morton 1966, "A computer oriented
/// geodetic data base"]. n calls of take() on islands of n lines look at a number of start points that is
/// proportional to n.
class NearestStart {
 public:
  /// Points at which a line may begin: [first, behind) of its points.
  struct Starts {
    std::uint32_t line, first, behind;
  };
  struct Place {
    std::uint32_t line, point;
  };
  /// Appends all points of a closed line, in blocks of at most 16 neighbours within a square of side `reach`:
  /// larger blocks of nested rings would all have the nozzle in their boxes.
  static void add_all(const geometry::Rings& lines, std::uint32_t line, double reach,
                      std::vector<Starts>& starts);

  /// @param lines must outlive the index
  /// @param starts of all lines, at least one of each, ascending by line
  NearestStart(const geometry::Rings& lines, std::span<const Starts> starts);

  bool empty() const { return left_ == 0; }
  /// Removes the line that has the start point nearest to `at`. Of several at the same distance it takes the
  /// first one in the order of the lines, which is cyclic and begins behind the line that was taken last.
  /// @pre not empty
  Place take(geometry::Point at);
  /// Returns the number of start points whose distances were computed.
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  const geometry::Rings& lines_;
  std::vector<Starts> leaves_;           // in the order of the tree
  std::vector<std::uint32_t> leaf_of_;   // of each of the starts
  std::vector<std::uint32_t> first_of_;  // of each line, and the end: its first starts
  std::size_t left_ = 0;                 // lines
  std::uint32_t next_ = 0;               // behind the line that was taken last
  std::uint64_t looked_at_ = 0;
  geometry::StaticRTree tree_;
};

}  // namespace firn::slice
