// All pairs of edges of closed lines that may meet, by the lines' monotone stretches.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/slice/box_pairs.h"

namespace firn::slice {

/// Edges, one after the other, cut into chains along which x only rises or only falls, and y as well. Edges of a chain do not
/// meet but at their ends, and what lies between two places of a chain lies in the box of the two: no tree is needed within
/// it, and a smooth line is a few chains.
class Chains {
 public:
  static constexpr int kBent = 4;  ///< an edge along which x or y turns: a chain of its own

  void clear() {
    chains_.clear();
    edges_ = 0;
    last_ = kBent;
  }
  /// The next edge. @param quadrant of its direction, the same for all equal pairs of signs: 0 to 3, or kBent
  void add(int quadrant, bool begins_line) {
    if (quadrant != last_ || quadrant == kBent || begins_line) {
      chains_.push_back({edges_, edges_, std::int8_t(quadrant), std::int8_t(begins_line ? kBent : last_)});
      last_ = quadrant;
    }
    chains_.back().end = ++edges_;
  }

  /// f(i, j), i < j, for all edges of different chains whose boxes meet, but for those of which it is known that they do not
  /// meet; for neighbours of different chains in any case.
  /// @param edges with from(i), to(i): places; bent(i): box of an edge that was added as kBent
  template <class Edges, class F>
  void pairs(const Edges& edges, F&& f) {
    using Box = decltype(edges.bent(0));
    const auto box = [&](const Chain& c) {
      if (c.bent()) return edges.bent(c.begin);
      Box b;
      b.add(edges.from(c.begin).x, edges.from(c.begin).y);
      b.add(edges.to(c.end - 1).x, edges.to(c.end - 1).y);
      return b;
    };
    tree_.resize(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) tree_.set(c, whole(box(chains_[c])));
    tree_.build();
    tree_.pairs([&](std::size_t c, std::size_t d) {
      const Chain &a = chains_[c], &b = chains_[d];
      if (d == c + 1 && b.goes_on()) f(std::size_t(a.end - 1), std::size_t(b.begin));
      else cross(a, b, box(a), box(b), box, f);
    });
  }

 private:
  struct Chain {
    std::uint32_t begin, end;
    std::int8_t quadrant;
    std::int8_t before;  // quadrant of the chain before it in its line; kBent: there is none, or it is bent
    bool bent() const { return quadrant == kBent; }
    // Seen along the axis whose sign they share, this chain lies behind the one before it.
    bool goes_on() const { return before == (quadrant ^ 1) || before == (quadrant ^ 2); }
  };

  static BoxTree::Box whole(const BoxOf<std::int32_t>& b) { return b; }
  static BoxTree::Box whole(const BoxOf<double>& b) {
    const auto unit = [](double v) { return std::int32_t(std::min(2.1e9, std::max(-2.1e9, v))); };
    return {unit(b.x0) - 1, unit(b.y0) - 1, unit(b.x1) + 1, unit(b.y1) + 1};
  }

  template <class Box, class BoxFor, class F>
  static void cross(Chain a, Chain b, Box box_a, Box box_b, const BoxFor& box, F& f) {
    while (box_a.meets(box_b)) {
      const std::uint32_t in_a = a.end - a.begin, in_b = b.end - b.begin;
      if (in_a == 1 && in_b == 1) {
        f(std::size_t(std::min(a.begin, b.begin)), std::size_t(std::max(a.begin, b.begin)));
        return;
      }
      Chain& longer = in_a > in_b ? a : b;
      Chain rest = longer;
      rest.begin = longer.end = longer.begin + (longer.end - longer.begin) / 2;
      if (in_a > in_b) {
        cross(rest, b, box(rest), box_b, box, f);
        box_a = box(a);
      } else {
        cross(a, rest, box_a, box(rest), box, f);
        box_b = box(b);
      }
    }
  }

  std::vector<Chain> chains_;
  std::uint32_t edges_ = 0;
  int last_ = kBent;
  BoxTree tree_;
};

}  // namespace firn::slice
