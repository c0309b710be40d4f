// All pairs of edges of closed lines that may meet, by the lines' monotone stretches.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/box_pairs.h"
#include "core/geometry/vec.h"

namespace firn::slice {

/// A box in doubles whose corners are compared two numbers at a time.
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
  /// In whole units, outward.
  BoxOf<std::int32_t> whole() const {
    const auto unit = [](double v) { return std::int32_t(std::min(2.1e9, std::max(-2.1e9, v))); };
    return {unit(low[0]) - 1, unit(low[1]) - 1, unit(high[0]) + 1, unit(high[1]) + 1};
  }
};

/// Edges, one after the other, cut into chains along which x only rises or only falls, and y as well. Edges
/// of a chain do not meet but at their ends, and what lies between two places of a chain lies in the box of
/// the two: no tree is needed within it, and a smooth line is a few chains. Nor do chains meet between which
/// x only rises or only falls, or y.
class Chains {
 public:
  /// How an edge runs, the sum of: x falls, y falls (else they rise), x turns on the way, y turns on the way.
  enum Run : int {
    kXFalls = 1,
    kYFalls = 2,
    kXTurns = 4,
    kYTurns = 8,
    kBent = kXTurns | kYTurns,
    kNone = -1
  };

  /// Of a straight edge.
  static int run_of(Vec way) {
    static_assert(kXFalls == 1 && kYFalls == 2);
    return lanes_of(PairBox::pair(way) < PairBox::Pair{});
  }

  void clear() { chains_.clear(); }
  /// Does a chain begin at an edge? @param last run of the edge before it, kNone at the beginning of a line
  static bool begins(int run, int last) { return run != last || run >= kXTurns; }
  void begin(std::uint32_t edge, int run, int last) {
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

  /// f(i, j), i < j, for all edges of different chains whose boxes meet, but for those of which it is known
  /// that they do not meet; for neighbours of different chains in any case.
  /// @param edges with from(i), to(i): places; bent(i): box of an edge that turns; grown, if all boxes are to
  /// be wider by that
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
    std::uint32_t x_since, y_since;  // chains of its line from which on x, or y, runs as it does here
    bool bent;
  };

  // Some edges of a chain.
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

  // Of parts whose boxes meet.
  template <class Edges, class F>
  static void cross(const Edges& edges, Part a, Part b, F& f) {
    while (a.end - a.begin > 1 || b.end - b.begin > 1) {
      const bool halves_a = a.end - a.begin > b.end - b.begin;
      Part &longer = halves_a ? a : b, &other = halves_a ? b : a;
      const std::uint32_t middle = longer.begin + (longer.end - longer.begin) / 2;
      const PairBox::Pair place = PairBox::pair(edges.from(middle));
      const Part rest{middle, longer.end, place, longer.to, box_of(edges, place, longer.to)};
      if (rest.box.meets(other.box)) halves_a ? cross(edges, rest, b, f) : cross(edges, a, rest, f);
      longer.end = middle, longer.to = place;
      longer.box = box_of(edges, longer.from, place);
      if (!longer.box.meets(other.box)) return;
    }
    f(std::size_t(std::min(a.begin, b.begin)), std::size_t(std::max(a.begin, b.begin)));
  }

  std::vector<Chain> chains_;
  BoxTree tree_;
};

}  // namespace firn::slice
