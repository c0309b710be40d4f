// Strands of the front at one distance, and where two of them cross.
#pragma once

#include "core/geometry/chains.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

inline constexpr std::int32_t kPivot = -1;  // instead of a source: a way to or from a pivot

// A stretch of curve: a piece, or one of the two straight ways to and from a pivot.
struct Strand {
  Vec a, b;
  std::int32_t piece = 0;  // index into the component's pieces
  std::int32_t source = 0;
  std::uint32_t next = 0;  // in its loop
};

inline bool is_arc(std::span<const Source> sources, const Strand& s) {
  return s.source != kPivot && sources[std::size_t(s.source)].corner();
}

// Where two strands cross.
struct Crossing {
  Vec at;
  std::uint32_t strand[2];
  double place[2];  // along each strand
};

// How the piece of a source runs at distance d. An arc of at most half a turn whose ends go the same way goes
// that way all along, and one of less than a quarter turns along one axis at most; one that has died may not
// end on its circle.
inline int run_of(const Source& source, Vec from, Vec to, double d) {
  if (!source.corner()) return Chains::run_of(to - from);
  const Vec a = from - source.at, b = to - source.at;
  const double square = d * d;
  if (std::abs(dot(a, a) - square) >= d || std::abs(dot(b, b) - square) >= d || cross(a, b) > 0)
    return Chains::kBent;
  const int run = Chains::run_of(right_of(a)), turned = run ^ Chains::run_of(right_of(b));
  if (turned == 0) return run;
  return dot(a, b) > 0 ? run | turned << 2 : int(Chains::kBent);
}

// The box of a strand at distance d.
inline BoxOf<double> box_of(std::span<const Source> sources, const Strand& s, double d) {
  // An arc of at most half a turn bulges by less than its squared chord over 4 d.
  const double bulge = is_arc(sources, s) ? dot(s.b - s.a, s.b - s.a) / (4 * d) : 0.0;
  return {std::min(s.a.x, s.b.x) - bulge, std::min(s.a.y, s.b.y) - bulge, std::max(s.a.x, s.b.x) + bulge,
          std::max(s.a.y, s.b.y) + bulge};
}

inline PairBox bent_box(std::span<const Source> sources, const Strand& strand, double d) {
  const BoxOf<double> box = box_of(sources, strand, d);
  return PairBox::of(Vec{box.x0, box.y0}, Vec{box.x1, box.y1});
}

// What Chains asks of strands.
struct StrandEdges {
  std::span<const Source> sources;
  const Strand* strands;
  double d;
  Vec from(std::size_t i) const { return strands[i].a; }
  Vec to(std::size_t i) const { return strands[i].b; }
  PairBox bent(std::size_t i) const { return bent_box(sources, strands[i], d); }
  std::size_t next(std::size_t i) const { return strands[i].next; }
  const Strand& strand(std::size_t i) const { return strands[i]; }
};

// The same of loops without pivots, whose pieces are their strands.
struct PieceEdges {
  std::span<const Source> sources;
  std::span<const Piece> pieces;
  const std::uint32_t* after;  // of each piece; null: there is one loop
  double d;
  Vec from(std::size_t i) const { return pieces[i].from; }
  Vec to(std::size_t i) const { return pieces[next(i)].from; }
  PairBox bent(std::size_t i) const { return bent_box(sources, strand(i), d); }
  std::size_t next(std::size_t i) const { return after ? after[i] : i + 1 < pieces.size() ? i + 1 : 0; }
  Strand strand(std::size_t i) const {
    return {from(i), to(i), std::int32_t(i), pieces[i].source, std::uint32_t(next(i))};
  }
};

// Calls found(place, along a, along b) for each place where two strands of the front at distance d cross;
// what is told along a strand grows from its a to its b, which is not part of it.
template <class F>
void intersect(std::span<const Source> sources, double d, const Strand& a, const Strand& b, F&& found) {
  const auto along = [&](const Strand& s, Vec p, double& place) {
    if (!is_arc(sources, s)) {
      const Vec way = s.b - s.a;
      place = dot(p - s.a, way);
      return place >= 0 && place < dot(way, way);
    }
    const Source& source = sources[std::size_t(s.source)];
    if (dot(p - source.at, left_of(source.along)) <= 0) return false;
    place = dot(p - source.at, source.along);
    return place >= dot(s.a - source.at, source.along) && place < dot(s.b - source.at, source.along);
  };
  const auto offer = [&](Vec p) {
    double on_a = 0, on_b = 0;
    if (along(a, p, on_a) && along(b, p, on_b)) found(p, on_a, on_b);
  };
  const bool a_bends = is_arc(sources, a), b_bends = is_arc(sources, b);
  if (!a_bends && !b_bends) {
    const Vec wa = a.b - a.a, wb = b.b - b.a;
    const double sine = cross(wa, wb);
    if (sine == 0) return;
    const double s = cross(b.a - a.a, wb) / sine, t = cross(b.a - a.a, wa) / sine;
    if (s >= 0 && s < 1 && t >= 0 && t < 1) found(a.a + s * wa, s * dot(wa, wa), t * dot(wb, wb));
    return;
  }
  if (a_bends && b_bends) {
    const Vec ca = sources[std::size_t(a.source)].at, between = sources[std::size_t(b.source)].at - ca;
    const double square = dot(between, between), height = d * d - 0.25 * square;
    if (square == 0 || height <= 0) return;
    const Vec side = std::sqrt(height / square) * left_of(between), mid = ca + 0.5 * between;
    offer(mid + side);
    offer(mid - side);
    return;
  }
  const Strand &line = a_bends ? b : a, &bow = a_bends ? a : b;
  const Vec way = line.b - line.a, centre = sources[std::size_t(bow.source)].at;
  const double square = dot(way, way);
  if (square == 0) return;
  const double foot = dot(centre - line.a, way) / square;
  const Vec off = line.a + foot * way - centre;
  const double height = d * d - dot(off, off);
  if (height <= 0) return;
  const double half = std::sqrt(height / square);
  offer(line.a + (foot - half) * way);
  offer(line.a + (foot + half) * way);
}

}  // namespace firn::slice::wavefront
