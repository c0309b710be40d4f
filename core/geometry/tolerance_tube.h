// ToleranceTube computes the straight lines that pass through consecutive cross-sections of a tube about a
// polyline.
//
// Each vertex of the polyline has a cross-section: a segment across the direction of travel that reaches as
// far to either side as the tolerance allows. The lines that pass through all cross-sections so far lie
// between two extreme supporting lines, one turned furthest to the left and one to the right. Each touches
// the convex hull of the cross-sections' ends on the far side first and the hull on the near side later
// [after O'Rourke 1981, "An on-line algorithm for fitting straight lines between data ranges"]. Where both
// miss the next cross-section, the region reachable beyond it is bounded by the supporting line of that side,
// between the point where it touches the near hull and the point where it leaves the tube. The next line
// starts from that window, which gives the minimum number of corners of any path in the tube [after Suri
// 1986, "A linear time algorithm for minimum link paths inside a simple polygon"].
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::geometry {

class ToleranceTube {
 public:
  enum class Turn { kNone, kLeft, kRight, kBack };
  struct Line {
    Vec at, along;
  };
  struct Width {
    double left, right;  ///< of a cross-section, to either side of its vertex
  };
  /// Part of a line that the next line crosses.
  struct Window {
    Line line;
    double first = 0, last = 0;  ///< how far along, in lengths of `along`
    /// Returns the point in which a line crosses the window.
    Vec crossing(const Line& by) const;
    Vec far_end() const { return line.at + last * line.along; }
  };

  /// Reserves memory for the cross-sections of a polyline.
  void reserve(std::size_t sections);
  /// Begins at a point, toward another one.
  void begin(Vec at, Vec toward);
  /// Adds the cross-sections at vertices from i on, as long as some line passes through all of them. @param i
  /// returns the first vertex that is missed, or the number of vertices @return the side on which it lies
  Turn take(std::span<const Vec> places, std::size_t& i, Width width);
  /// A line through all cross-sections and its end: at the last vertex if all of the last cross-section can
  /// be reached (the part before it is straight), else midway between the supporting lines.
  struct End {
    Line line;
    Vec at;
  };
  End end() const;
  bool spans_last_section() const;
  /// Computes the supporting line of one side, from its contact with the near hull to the point where it
  /// leaves the tube before a cross-section that was missed on that side. @return false if there is no such
  /// line
  bool window(Turn turn, Vec missed, Width width, Window& window) const;
  /// Begins again in a window that window() computed, or in the part of it behind the last cross-section if
  /// the polyline bends much there.
  /// @return false, without any change, if it bends too sharply
  bool pass_on(Turn turn, Window& window, Vec toward, Vec missed);

 private:
  // Both hulls are stored as upper bounds: [0] the left one, [1] the right one mirrored, with x along and y
  // left of `along_`. The supporting line of a side touches the hull of that side at its contact, and the
  // hull of the other side before that at its support.
  struct Hull {
    Vec* ends = nullptr;                         // of cross-sections that may yet bound a line: a convex hull
    Vec* behind = nullptr;                       // behind the last one
    Vec *support = nullptr, *contact = nullptr;  // `contact` may be null
    double slope = 0, offset = 0;                // of the supporting line of this side

    void aim(Vec through, double to_slope) {
      slope = to_slope;
      offset = through.y - to_slope * through.x;
    }
    double at(double x) const { return offset + slope * x; }
    void begin(Vec end);
    void move_support(Vec end);
    void add(Vec end, bool touched, unsigned hidden);
  };
  Vec frame(Vec place) const { return {dot(along_, place - origin_), cross(along_, place - origin_)}; }
  Vec place(Vec in_frame) const { return origin_ + in_frame.x * along_ + in_frame.y * left_of(along_); }

  Vec origin_, along_;
  double reach_ = 0;
  double last_[2] = {}, last_place_ = 0;  // the last cross-section: ends, each from its side, and vertex
  Hull hulls_[2];
  std::vector<Vec> ends_;  // the hulls'
};

}  // namespace firn::geometry
