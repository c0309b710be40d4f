// WavefrontEdge, Component and their operations compute the wavefront of an outline: at distance d it is the
// exact offset curve.
//
// The wavefront moves inward at unit speed. It consists of straight edges, each parallel to a segment of the
// outline, and of arcs about its reflex corners. Each edge refers to its site, the segment or corner that
// generates it, and every point of the wavefront is computed from the *original* sites at the requested
// distance and not from a previous ring: errors do not accumulate. Only the order of the active sites is
// handed from one distance to the next. A site that has vanished remains so, and the work shrinks with the
// rings. The common point of two neighbours moves along the bisector of their sites (a line, a parabola or
// the bisector of two corners: an edge of the segment Voronoi diagram), of which each step follows only the
// part it needs.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/region.h"
#include "core/geometry/rtree.h"
#include "core/geometry/vec.h"
#include "core/slice/offset/cusp_corrector.h"

namespace firn::slice::wavefront {

/// A site: a segment of the outline (area on its left) or a reflex corner.
struct Site {
  geometry::Vec at;     ///< first point of the segment; the corner
  geometry::Vec along;  ///< unit direction; for a corner the direction at the middle of its arc
  double length = 0;    ///< of the segment; < 0 for a corner
  bool corner() const { return length < 0; }
};

/// The bisector of two sites: the common point of their wavefront edges as a function of the distance d.
class Bisector {
 public:
  enum class Kind : std::int32_t { kStraight, kParabolaAhead, kParabolaBack, kTwoCorners };

  Bisector() = default;
  Bisector(geometry::Vec at_0, geometry::Vec velocity) : base(at_0), direction(velocity) {}
  Bisector(Kind of, geometry::Vec from, geometry::Vec along, double by)
      : base(from), direction(along), bound(by), kind(of) {}

  /// kStraight: point at d = 0; parabola: projection of the corner to the line; kTwoCorners: midpoint.
  geometry::Vec base;
  /// kStraight: velocity; parabola: along the line, away from the projection; kTwoCorners: left of first ->
  /// second.
  geometry::Vec direction;
  double bound = 0;  ///< parabola: height of the corner over the line; kTwoCorners: squared half distance
  Kind kind = Kind::kStraight;  ///< of a parabola: its direction is along the line or against it

  geometry::Vec normal() const {
    return kind == Kind::kParabolaAhead ? left_of(direction) : right_of(direction);
  }  ///< normal of the line of a parabola
  geometry::Vec operator()(double d) const {
    return kind == Kind::kStraight ? base + d * direction : bent(d);
  }

 private:
  geometry::Vec bent(double d) const {
    const bool corners = kind == Kind::kTwoCorners;
    const double square = corners ? d * d - bound : bound * (2 * d - bound);
    const geometry::Vec aside = (square > 0 ? std::sqrt(square) : 0.0) * direction;
    return corners ? base + aside : base + d * normal() + aside;
  }
};

/// An edge of the wavefront, from its bisector with the edge before it to that of the next edge.
struct WavefrontEdge {
  [[no_unique_address]] Bisector start;  ///< with the edge before; `site` uses its padding
  std::int32_t site = 0;                 ///< < 0: a pivot, ~ the index of its point
  geometry::Vec from;                    ///< start at the present distance of the wavefront
  bool pivot() const { return site < 0; }
};
static_assert(sizeof(WavefrontEdge) == 64);  // the complete shape of the wavefront, traversed many times

/// The loops that bound one connected area. They may still intersect each other, but not those of another
/// component.
///
/// A pivot keeps a loop closed where the edges between two others have collapsed and these have no bisector
/// ahead: the loop runs from the end of the edge before the pivot straight to a fixed point, and straight on
/// to the start of the next edge. Pivots occur only in parts of the wavefront that are invalid already, and
/// trimming removes them.
struct Component {
  std::vector<WavefrontEdge> edges;   ///< of all loops, one after the other
  std::vector<std::uint32_t> ends;    ///< of each loop
  std::vector<geometry::Vec> pivots;  ///< points of the pivots among the edges
  geometry::Vec place_of(const WavefrontEdge& pivot) const { return pivots[std::size_t(~pivot.site)]; }
};

/// Components with reused memory.
class Components {
 public:
  void clear() { size_ = 0; }
  Component& add() {  ///< adds an empty one
    if (size_ == all_.size()) all_.emplace_back();
    Component& component = all_[size_++];
    component.edges.clear();
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

/// Computes the wavefront of an area at distance 0. @param area rings of the region: an outer one with its
/// holes
void wavefront_of(const geometry::Region& region, std::span<const std::uint32_t> area,
                  std::vector<Site>& sites, Components& components);

/// Computes the bisector of two consecutive sites whose edges meet at `place` at distance `d`.
/// @return false if there is no bisector ahead (they turn away from each other by half a turn or more)
bool bisector_of(const Site& before, const Site& after, geometry::Vec place, double d, Bisector& bisector);

/// Propagates a component from distance `from` to `to` and handles edge events: an edge collapses before its
/// neighbours do, so that adjacency is always correct. Loops without edges vanish. Afterwards the wavefront
/// may intersect itself. Keeps its working memory.
class Propagation {
 public:
  void operator()(std::span<const Site> sites, Component& component, double from, double to);
  /// Lists from now on local maxima of the distance from the outline, beyond `from`.
  void list_peaks(double from) {
    peaks_from_ = from;
    peaks_.clear();
  }
  std::span<const geometry::Vec> peaks() const { return peaks_; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Link {
    std::int32_t prev = 0, next = 0;  // next < 0: collapsed
    double edge_event = kNever;       // distance at which the edge collapses between its present neighbours
  };
  void list_inverted();
  bool run(double from);
  WavefrontEdge* close_up(WavefrontEdge* to) const;
  void link();
  void unlink();
  void predict_event(std::int32_t i, double since);
  void collapse(std::int32_t i, double d);
  void run_events_about(std::int32_t i);
  bool sooner(std::int32_t i, std::int32_t than) const;
  Bisector radial(std::int32_t i, geometry::Vec place) const;
  bool peak(std::int32_t a, std::int32_t b, std::int32_t c, geometry::Vec place) const;

  std::span<const Site> sites_;
  Component* component_ = nullptr;
  std::span<WavefrontEdge> edges_of_loop_;  // of one loop
  double to_ = 0;
  std::vector<std::int32_t> inverted_;
  std::vector<Link> links_;                // between loops each entry is linked to the adjacent indices
  std::vector<std::int32_t> linked_anew_;  // entries where that does not hold
  std::vector<std::int32_t> pending_;
  double peaks_from_ = std::numeric_limits<double>::infinity();
  std::vector<geometry::Vec> peaks_;
  bool any_collapsed_ = false;
  std::int32_t remaining_ = 0;  // edges with a site
};

/// Trims self-intersections of a propagated component (split events): keeps the parts at least `d` from all
/// sites, as new components. Keeps its working memory.
class SelfIntersectionTrimmer {
 public:
  SelfIntersectionTrimmer();
  ~SelfIntersectionTrimmer();
  /// Begins a new wavefront. @param sites all of its sites, which must outlive their use
  void begin(std::span<const Site> sites);
  /// @return false if points coincide within rounding: then the caller uses Clipper
  bool operator()(Component& component, double d, Components& out);

 private:
  class Trimming;
  std::unique_ptr<Trimming> trimming_;
};

/// Computes the nesting of loops that do not intersect: components of outer loops with the holes in them.
/// Holes outside all outer loops vanish. Keeps its working memory.
class HoleNesting {
 public:
  /// @param loops components of one loop each; their contents are moved from
  void operator()(std::span<const Site> sites, Components& loops, double d, Components& out);

 private:
  static constexpr std::size_t kNone = ~std::size_t(0);
  void list_holes(std::span<const Site> sites, std::span<const Component> loops, double d);
  std::vector<double> areas_;
  std::vector<std::size_t> outers_, outer_of_;
  std::vector<std::vector<geometry::Vec>> corners_;  // of outers_, if there are several
  geometry::StaticRTree boxes_;                      // of these
};

/// Returns the middle of the edge of a site from a to b at distance d.
geometry::Vec middle(const Site& site, geometry::Vec a, geometry::Vec b, double d);

/// Appends the loops of the component at distance d: arcs as chords, simplified, in all within `tolerance`
/// units of the exact curve. Loops smaller than the grid vanish. Keeps its working memory.
/// @param cusps corrects the cusps by the contours from which the outline was simplified; may be null
class Drawer {
 public:
  void operator()(std::span<const Site> sites, const Component& component, double d, double tolerance,
                  geometry::Rings& rings, CuspCorrector* cusps);

 private:
  struct Cusp {
    std::size_t place;  // index in the line
    geometry::Vec from, to, outward;
    CuspCorrector::Side before;
    std::uint32_t edge;
  };
  // Bends along a loop: consecutive bends close to each other are one cusp, with the sum of their turns.
  struct Bends {
    std::size_t first = 0;     // edge at whose start the present group begins
    geometry::Vec from, last;  // direction of the outline before the group; last point of the group
    bool sharp = false;        // whether the group is a cusp
  };
  void cusp_at(std::span<const Site> sites, std::span<const WavefrontEdge> loop, std::size_t first,
               std::size_t edge, double d, CuspCorrector& cusps);
  bool move_cusps();
  void leave_out();
  bool looks_narrow_on_average(double width) const;
  void list_third_sides(CuspCorrector& cusps, double d) const;
  double twice_area() const;
  std::vector<geometry::Vec> line_;
  std::vector<Cusp> cusps_;
  std::vector<std::uint32_t> places_;    // index in the line of each edge of the loop
  std::vector<std::uint32_t> left_out_;  // indices in the line
  double twice_area_ = 0;                // of the line with corrected cusps
};

}  // namespace firn::slice::wavefront
