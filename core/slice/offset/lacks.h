// What of the front at one distance has no front near it at the next: where rings leave spots between them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/stretches.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

/// How far the front at the next distance may be from a place that does not lack it.
struct LackLimits {
  double near = 0;         ///< anywhere
  double far = 0;          ///< so near is all of a cornered stretch that has no spot
  double near_corner = 0;  ///< from a corner of two walls, along which it runs there
  double slack = 0;        ///< what lies so far outside such a corner is as good as in it
  double narrowest = 0;    ///< loops round an area no wider than this lack nothing
};

/// Pieces that live on stand beside what they stood at before; what died between two of them, and the ways of
/// their ends, lie about one corner of the next front. If all its corners are near that one, all of it is:
/// the distance from a place is convex along a line, and arcs bulge towards it.
///
/// A stretch whose two living neighbours are neighbours still is cornered. Both ways from the corner P in
/// which these meet back to their pieces run through what the two passed over. What lies between the ways was
/// passed by the stretch's pieces alone, unless a hole died there, loop and all; and any way from there to
/// the next front either crosses one of the two in a place z, from which no place of the next front is nearer
/// than P (z is as much less deep as it is far from P), or leaves the area: P is the nearest place of the
/// next front. Keeps its working memory.
class Lacks {
 public:
  /// Before a component moves on from distance `d`.
  void keep(const Component& component, double d);
  /// After it has: appends stretches of what was kept.
  /// @param out the components that it has become
  /// @param sagitta of the chords of arcs
  void find(std::span<const Source> sources, std::span<const Component> out, const LackLimits& limits,
            double sagitta, Stretches& stretches);

 private:
  struct Kept {
    std::int32_t source;
    Vec from;
  };
  struct Ahead {  // a piece of the next front
    Vec from;
    std::int32_t source, next;
  };
  static constexpr std::int32_t kGone = -1, kSeveral = -2;

  void find_in(std::span<const Kept> loop, const LackLimits& limits, double sagitta, Stretches& stretches);
  bool served(std::span<const Kept> loop, std::size_t i, std::size_t steps, const LackLimits& limits) const;
  bool cornered(std::span<const Kept> loop, std::size_t i, std::size_t steps) const;
  bool blunt(std::span<const Kept> loop, std::size_t i, std::size_t steps, Vec corner,
             const LackLimits& limits) const;
  void add_stretch(std::span<const Kept> loop, std::size_t i, std::size_t steps, double sagitta,
                   Stretches& stretches);
  void add_all(std::span<const Kept> loop, const LackLimits& limits, double sagitta,
               Stretches& stretches) const;
  Vec beside(const Kept& piece, Vec ahead) const;
  void add_arc(const Kept& piece, Vec a, Vec b, double sagitta, std::vector<Vec>& points) const;

  std::span<const Source> sources_;
  double d_ = 0;
  std::vector<Kept> kept_;
  std::vector<std::uint32_t> ends_;
  std::vector<std::int32_t> at_;  // [source]: its piece of the next front
  std::vector<Ahead> ahead_;
  bool loop_died_ = false;
};

}  // namespace firn::slice::wavefront
