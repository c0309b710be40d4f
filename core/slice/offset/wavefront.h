// The front that runs inward from an outline at unit speed: its shape at distance d is the outline's exact
// offset.
//
// The front consists of straight pieces, each parallel to a segment of the outline, and of arcs about its
// reflex corners. A piece knows the segment or corner (its source) that it comes from, and every place of the
// front is computed from the *original* sources at the asked distance, never from an earlier ring: errors
// cannot pile up. What is handed from one distance to the next is only which sources are still alive and in
// which order: sources that have died stay dead, so the work shrinks with the rings. Where two neighbours
// meet they move along the bisector of their sources (a line, parabola or line of two corners: an edge of the
// segment Voronoi diagram), of which each step walks just the part it needs.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/slice/offset/exact_tips.h"
#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::slice::wavefront {

/// A segment of the outline (area on its left) or a reflex corner.
struct Source {
  Vec at;             ///< the segment's first point; the corner
  Vec along;          ///< unit: direction of travel; for a corner that at the middle of its arc
  double length = 0;  ///< of the segment; < 0: a corner
  bool corner() const { return length < 0; }
};

/// Where two neighbours of the front meet, as a function of distance d from the outline.
class Junction {
 public:
  enum class Kind : std::int32_t { kStraight, kParabolaAhead, kParabolaBack, kTwoCorners };

  Junction() = default;
  Junction(Vec at_0, Vec velocity) : base(at_0), direction(velocity) {}
  Junction(Kind of, Vec from, Vec along, double by) : base(from), direction(along), bound(by), kind(of) {}

  Vec base;  ///< kStraight: place at d = 0; parabola: foot of the corner on the line; kTwoCorners: midpoint
  Vec direction;  ///< kStraight: velocity; parabola: along the line, away from the foot; kTwoCorners: left of
                  ///< first -> second
  double bound = 0;  ///< parabola: height of the corner over the line; kTwoCorners: squared half distance
  Kind kind = Kind::kStraight;  ///< a parabola's direction is that of its line, or back along it

  Vec normal() const {
    return kind == Kind::kParabolaAhead ? left_of(direction) : right_of(direction);
  }  ///< of a parabola's line
  Vec operator()(double d) const { return kind == Kind::kStraight ? base + d * direction : bent(d); }

 private:
  Vec bent(double d) const {
    const bool corners = kind == Kind::kTwoCorners;
    const double square = corners ? d * d - bound : bound * (2 * d - bound);
    const Vec aside = (square > 0 ? std::sqrt(square) : 0.0) * direction;
    return corners ? base + aside : base + d * normal() + aside;
  }
};

/// One piece of the front, from its own junction to that of the next piece.
struct Piece {
  [[no_unique_address]] Junction start;  ///< with the piece before; `source` lies in what pads it
  std::int32_t source = 0;               ///< < 0: a pivot, ~ the number of its place
  Vec from;                              ///< start at the front's present distance
  bool pivot() const { return source < 0; }
};
static_assert(sizeof(Piece) == 64);  // all there is of the front's present shape, walked many times

/// Loops of pieces that bound one connected area; all of them may still meet each other, but none of another
/// component.
///
/// A pivot keeps the front closed where what lay between two pieces died and they have no bisector ahead: the
/// front goes from the end of the piece before straight to a fixed place and straight on to the start of the
/// next. It occurs only in parts of the front that have died already, and untangle() removes it with them.
struct Component {
  std::vector<Piece> pieces;        ///< of all loops, one after the other
  std::vector<std::uint32_t> ends;  ///< of each loop
  std::vector<Vec> pivots;          ///< places of those among the pieces
  Vec place_of(const Piece& pivot) const { return pivots[std::size_t(~pivot.source)]; }
};

/// Components whose memory is used again.
class Components {
 public:
  void clear() { size_ = 0; }
  Component& add() {  ///< an empty one
    if (size_ == all_.size()) all_.emplace_back();
    Component& component = all_[size_++];
    component.pieces.clear();
    component.ends.clear();
    component.pivots.clear();
    return component;
  }
  void take(Component& component) { std::swap(add(), component); }
  std::size_t size() const { return size_; }
  std::span<Component> all() { return std::span(all_).first(size_); }

 private:
  std::vector<Component> all_;
  std::size_t size_ = 0;
};

/// Front of an area at distance 0. @param area rings of the region: an outer one with its holes
void front_of(const Region& region, std::span<const std::uint32_t> area, std::vector<Source>& sources,
              Components& components);

/// Bisector of two sources that follow each other on the front and meet at `place` at distance `d`.
/// @return false if they have none ahead (they turn away from each other by half a turn or more)
bool meet(const Source& before, const Source& after, Vec place, double d, Junction& junction);

/// Moves a component from distance `from` to `to`: a piece dies when neither neighbour dies before, so that
/// neighbours are always right; loops that die out vanish. The front may cross itself afterwards. Keeps its
/// working memory.
class Mover {
 public:
  void operator()(std::span<const Source> sources, Component& component, double from, double to);
  /// From now on places are listed that the front reaches last of all about them, further than `from` from
  /// the outline.
  void list_peaks(double from) { peaks_from_ = from, peaks_.clear(); }
  std::span<const Vec> peaks() const { return peaks_; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Link {
    std::int32_t prev = 0, next = 0;  // next < 0: dead
    double death = kNever;            // at which distance it dies, as its neighbours are
  };
  void list_inverted();
  bool run(double from);
  Piece* close_up(Piece* to) const;
  void link();
  void unlink();
  void expect_death(std::int32_t i, double since);
  void die(std::int32_t i, double d);
  void die_about(std::int32_t i);
  bool sooner(std::int32_t i, std::int32_t than) const;
  Junction radial(std::int32_t i, Vec place) const;
  bool peak(std::int32_t a, std::int32_t b, std::int32_t c, Vec place) const;

  std::span<const Source> sources_;
  Component* component_ = nullptr;
  std::span<Piece> pieces_;  // of one loop
  double to_ = 0;
  std::vector<std::int32_t> inverted_;
  std::vector<Link> links_;                // between loops each with the places beside it
  std::vector<std::int32_t> linked_anew_;  // where that does not hold
  std::vector<std::int32_t> dying_;
  double peaks_from_ = std::numeric_limits<double>::infinity();
  std::vector<Vec> peaks_;
  bool any_dead_ = false;
  std::int32_t alive_ = 0;  // pieces with a source
};

/// Takes away what a moved component has passed over: keeps the parts at least `d` from all sources, as new
/// components. Keeps its working memory.
class Untangler {
 public:
  Untangler();
  ~Untangler();
  /// A new front. @param sources all of it; they stay where they are
  void begin(std::span<const Source> sources);
  /// @return false if it cannot tell (places that coincide to within rounding): the caller asks Clipper
  /// instead
  bool operator()(Component& component, double d, Components& out);

 private:
  class Tangle;
  std::unique_ptr<Tangle> tangle_;
};

/// Makes components of loops that do not cross: outer ones with the holes they contain. Holes without one
/// vanish. Keeps its working memory.
class Regroup {
 public:
  /// @param loops one each; what becomes of them is not told
  void operator()(std::span<const Source> sources, Components& loops, double d, Components& out);

 private:
  static constexpr std::size_t kNone = ~std::size_t(0);
  void list_holes(std::span<const Source> sources, std::span<const Component> loops, double d);
  std::vector<double> areas_;
  std::vector<std::size_t> outers_, outer_of_;
  std::vector<std::vector<Vec>> corners_;
};

/// Middle of the piece of a source that runs from a to b at distance d.
Vec middle(const Source& source, Vec a, Vec b, double d);

/// Appends the component's loops at distance d: arcs by chords, points left out, in all within `tolerance`
/// units of the exact curve. Loops that are smaller than the grid vanish. Keeps its working memory.
/// @param tips of the contours that the outline was thinned from: the front's tips are put where theirs are;
/// may be null
class Drawer {
 public:
  void operator()(std::span<const Source> sources, const Component& component, double d, double tolerance,
                  Rings& rings, ExactTips* tips);

 private:
  struct Tip {
    std::size_t place;  // in the line
    Vec from, to, outward;
    ExactTips::Wall before;
    std::uint32_t piece;
  };
  // Where the front goes from one source to the next, piece by piece of a loop: bends that follow each other
  // closely are one tip, as sharp as all of them.
  struct Bends {
    std::size_t first = 0;  // piece at whose start the last ones near each other begin
    Vec from, last;         // direction of the outline before them; place of the last one
    bool sharp = false;     // are they a tip?
  };
  void tip_at(std::span<const Source> sources, std::span<const Piece> loop, std::size_t first,
              std::size_t piece, double d, ExactTips& tips);
  bool move_tips();
  void leave_out();
  bool looks_thin(double width) const;
  void list_third_walls(ExactTips& tips, double d) const;
  double twice_area() const;
  std::vector<Vec> line_;
  std::vector<Tip> tips_;
  std::vector<std::uint32_t> places_;    // in the line, of each piece of the loop
  std::vector<std::uint32_t> left_out_;  // places
  double twice_area_ = 0;                // of the line, its tips moved
};

}  // namespace firn::slice::wavefront
