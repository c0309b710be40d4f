// Straight lines that pass all gates of a corridor, gate after gate.
//
// A gate stands across the way at a place of a line that is to be thinned, as far to either side of it as is
// allowed there. What passes all gates is bounded by two lines, the ones that turn furthest to the left and
// to the right; both touch the far wall first and the near one later, where the convex hulls of the gates'
// ends tell [after O'Rourke 1981, "An on-line algorithm for fitting straight lines between data ranges"].
// Where the next gate is missed, all that can be reached beyond lies on the line turned furthest to that
// side, between where it touches the near wall and where it leaves the corridor: from that window the next
// line sets out, which gives the fewest corners that any line in the corridor has [after Suri 1986, "A linear
// time algorithm for minimum link paths inside a simple polygon"].
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/vec.h"

namespace firn::slice {

class Corridor {
 public:
  enum class Turn { kNone, kLeft, kRight, kBack };
  struct Line {
    Vec at, along;
  };
  struct Width {
    double left, right;  ///< of a gate's place, to either side
  };
  /// Part of a line through which the next one passes.
  struct Window {
    Line line;
    double first = 0, last = 0;  ///< how far along, in lengths of `along`
    /// Where a line through the window crosses it.
    Vec crossing(const Line& by) const;
    Vec far_end() const { return line.at + last * line.along; }
  };

  /// Makes room for the gates of a line.
  void reserve(std::size_t gates);
  /// Begins at a place, toward another one.
  void begin(Vec at, Vec toward);
  /// Takes the gates at a line's places, as far as lines pass them all, from place i on. @param i then the
  /// place that is missed, or the line's size @return on which side it lies
  Turn take(std::span<const Vec> places, std::size_t& i, Width width);
  /// A line that passes all gates, and where it passes the last one: at its place if it can be passed
  /// everywhere (then what led there is straight), else midway between the lines turned furthest.
  struct End {
    Line line;
    Vec at;
  };
  End end() const;
  bool last_is_whole() const;
  /// The line turned furthest to a side, from where it touches the near wall to where it leaves the corridor
  /// before a gate that was missed on that side. @return false if there is none
  bool window(Turn turn, Vec missed, Width width, Window& window) const;
  /// Begins anew in a window that window() gave, or in the part of it behind the last gate if the way bends
  /// much there.
  /// @return false, and nothing has changed, if it bends too sharply
  bool pass_on(Turn turn, Window& window, Vec toward, Vec missed);

 private:
  // Both walls are seen as ceilings: [0] the left one, [1] the right one turned over, in x along and y left
  // of `along_`. A line turned furthest to a side touches that side's hull at its contact, and before that
  // the other side's at its support.
  struct Wall {
    Vec* ends = nullptr;    // of gates, seen from this side: those that may yet bound a line, a convex hull
    Vec* behind = nullptr;  // the last
    Vec *support = nullptr, *contact = nullptr;  // the second: may be none
    double slope = 0, offset = 0;                // of the line turned furthest to this side

    void aim(Vec through, double to_slope) { slope = to_slope, offset = through.y - to_slope * through.x; }
    double at(double x) const { return offset + slope * x; }
    void begin(Vec end);
    void move_support(Vec end);
    void add(Vec end, bool touched, unsigned hidden);
  };
  Vec frame(Vec place) const { return {dot(along_, place - origin_), cross(along_, place - origin_)}; }
  Vec place(Vec in_frame) const { return origin_ + in_frame.x * along_ + in_frame.y * left_of(along_); }

  Vec origin_, along_;
  double reach_ = 0;
  double last_[2] = {}, last_place_ = 0;  // ends of the last gate, each seen from its side, and its place
  Wall walls_[2];
  std::vector<Vec> ends_;  // the walls'
};

}  // namespace firn::slice
