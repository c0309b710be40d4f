// MonotoneChains finds all pairs of edges of closed curves that may intersect.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/rtree.h"
#include "core/geometry/vec.h"

namespace firn::geometry {

/// An axis-aligned box whose corners are compared two coordinates at a time.
struct PairBox {
  using Pair = Lanes2;
  Pair low, high;

  static Pair pair(Vec v) { return Pair{v.x, v.y}; }
  static Pair pair(Point p) { return Pair{double(p.x), double(p.y)}; }
  static Pair pair(Pair p) { return p; }
  template <class P>
  static PairBox of(P a, P b) {
    const Pair p = pair(a), q = pair(b);
    return {p < q ? p : q, p > q ? p : q};
  }
  PairBox with(const PairBox& o) const { return {low < o.low ? low : o.low, high > o.high ? high : o.high}; }
  PairBox grown(double by) const { return {low - Pair{by, by}, high + Pair{by, by}}; }
  bool meets(const PairBox& o) const { return lanes_of((low > o.high) | (o.low > high)) == 0; }
  /// Returns the box in integer units, rounded outward.
  BoxOf<std::int32_t> whole() const {
    const auto unit = [](double v) { return std::int32_t(std::min(2.1e9, std::max(-2.1e9, v))); };
    return {unit(low[0]) - 1, unit(low[1]) - 1, unit(high[0]) + 1, unit(high[1]) + 1};
  }
};

/// Consecutive edges are divided into chains along which x and y are both monotone. Edges of one chain
/// intersect only at their common ends, and the part between two points of a chain lies in the box of these
/// points, so the halves of a chain form an implicit tree. Neither do chains intersect between which x or y
/// stays monotone. Only the chains become leaves of the R-tree (rtree.h): with one leaf per edge, slicing a
/// scanned part takes 11 % more instructions.
class MonotoneChains {
 public:
  /// Monotonicity of an edge, a sum of flags: x falls, y falls (else they rise), x has an extremum inside the
  /// edge, y has one.
  enum Run : int {
    kXFalls = 1,
    kYFalls = 2,
    kXTurns = 4,
    kYTurns = 8,
    kBent = kXTurns | kYTurns,
    kNone = -1
  };

  /// Returns the flags of a straight edge.
  static int run_of(Vec way) {
    static_assert(kXFalls == 1 && kYFalls == 2);
    return lanes_of(PairBox::pair(way) < PairBox::Pair{});
  }

  void clear() { chains_.clear(); }
  /// Returns whether a chain begins at an edge. @param last flags of the edge before it, kNone at the
  /// beginning of a curve
  static bool begins(int run, int last) { return run != last || run >= kXTurns; }
  [[gnu::always_inline]] void begin(std::uint32_t edge, int run, int last) {
    const std::uint32_t here = std::uint32_t(chains_.size());
    Chain chain{edge, edge, here, here, run >= kXTurns};
    if (here > 0) {
      chains_.back().end = edge;
      if (last != kNone && !(run & kXTurns) && !((run ^ last) & (kXFalls | kXTurns)))
        chain.x_since = chains_.back().x_since;
      if (last != kNone && !(run & kYTurns) && !((run ^ last) & (kYFalls | kYTurns)))
        chain.y_since = chains_.back().y_since;
    }
    chains_.push_back(chain);
  }
  void end(std::uint32_t edges) {
    if (!chains_.empty()) chains_.back().end = edges;
  }

  /// Calls f(i, j), i < j, for all edges of different chains whose boxes meet, except those that are known
  /// not to intersect. Neighbours of different chains are always reported.
  /// @param edges an object with from(i) and to(i), the end points, bent(i), the box of an edge that is not
  /// monotone, and optionally `grown`, a margin of all boxes
  template <class Edges, class F>
  void pairs(const Edges& edges, F&& f) {
    const auto part = [&](const Chain& c) {
      const PairBox::Pair from = PairBox::pair(edges.from(c.begin)), to = PairBox::pair(edges.to(c.end - 1));
      return Part{c.begin, c.end, from, to,
                  c.bent ? grown(edges, edges.bent(c.begin)) : box_of(edges, from, to)};
    };
    tree_.resize(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) tree_.set(c, part(chains_[c]).box.whole());
    tree_.build();
    tree_.pairs([&](std::size_t c, std::size_t d) {
      const Chain &a = chains_[c], &b = chains_[d];
      if (std::min(b.x_since, b.y_since) > c) {
        const Part one = part(a), other = part(b);
        if (one.box.meets(other.box)) cross(edges, one, other, f);
      } else if (d == c + 1) {
        f(std::size_t(a.end - 1), std::size_t(b.begin));
      }
    });
  }

 private:
  struct Chain {
    std::uint32_t begin, end;
    std::uint32_t x_since, y_since;  // first chain of the curve since which x, or y, has been monotone
    bool bent;
  };

  // Consecutive edges of a chain.
  struct Part {
    std::uint32_t begin, end;
    PairBox::Pair from, to;
    PairBox box;
  };
  template <class Edges>
  static PairBox grown(const Edges& edges, const PairBox& box) {
    if constexpr (requires { edges.grown; })
      return box.grown(edges.grown);
    else
      return box;
  }
  template <class Edges>
  static PairBox box_of(const Edges& edges, PairBox::Pair from, PairBox::Pair to) {
    return grown(edges, PairBox::of(from, to));
  }

  // Parts whose boxes meet.
  template <class Edges, class F>
  static void cross(const Edges& edges, Part a, Part b, F& f) {
    while (a.end - a.begin > 1 || b.end - b.begin > 1) {
      const bool halves_a = a.end - a.begin > b.end - b.begin;
      Part &longer = halves_a ? a : b, &other = halves_a ? b : a;
      const std::uint32_t middle = longer.begin + (longer.end - longer.begin) / 2;
      const PairBox::Pair place = PairBox::pair(edges.from(middle));
      const Part rest{middle, longer.end, place, longer.to, box_of(edges, place, longer.to)};
      if (rest.box.meets(other.box)) halves_a ? cross(edges, rest, b, f) : cross(edges, a, rest, f);
      longer.end = middle;
      longer.to = place;
      longer.box = box_of(edges, longer.from, place);
      if (!longer.box.meets(other.box)) return;
    }
    f(std::size_t(std::min(a.begin, b.begin)), std::size_t(std::max(a.begin, b.begin)));
  }

  std::vector<Chain> chains_;
  StaticRTree tree_;
};

}  // namespace firn::geometry
