// Global deaths: where parts of the front that are no neighbours have run through each other.
//
// At every crossing the two strands change partners (Seifert's smoothing), which leaves closed loops that do not cross.
// Each loop lies wholly on the true offset or wholly in what the front has passed over, so the distance of one of its
// places from the sources decides for all of it.
#include <algorithm>

#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kTiny = 10.0;    // units: loops shorter than 1 um are dropped
constexpr double kPassed = 0.05;  // units: a place nearer than d - kPassed to a source has been passed

// A stretch of curve: a piece, or one of the two straight ways to and from a pivot.
struct Strand {
  Vec a, b;
  std::int32_t piece = 0;   // index into the component's pieces
  std::int32_t source = 0;  // kPivot: a way to or from a pivot
  std::uint32_t next = 0;   // in its loop
};

struct Crossing {
  Vec at;
  std::uint32_t strand[2];
  double place[2];  // along each strand
};

// What is left of a strand between two crossings.
struct Fragment {
  std::uint32_t strand;
  Vec from, to;
  std::uint32_t next = 0;
  bool crossed = false;     // begins at a crossing (then `before` is the source it comes from)
  bool right_turn = false;  // begins at a crossing by turning right: bounds passed area on its other side
  std::int32_t before = 0;
  bool done = false;
};

BoxOf<double> box_of(std::span<const Source> sources, Vec a, Vec b, std::int32_t source, double d) {
  BoxOf<double> box;
  box.add(a.x, a.y), box.add(b.x, b.y);
  if (source != kPivot && sources[std::size_t(source)].corner()) {
    // An arc of at most half a turn bulges by less than its squared chord over 4 d.
    const double bulge = dot(b - a, b - a) / (4 * d);
    box.x0 -= bulge, box.y0 -= bulge, box.x1 += bulge, box.y1 += bulge;
  }
  return box;
}

bool is_arc(std::span<const Source> sources, const Strand& s) {
  return s.source != kPivot && sources[std::size_t(s.source)].corner();
}

// Calls found(place, along a, along b) for each place where two strands of the front at distance d cross; what is told
// along a strand grows from its a to its b, which is not part of it.
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

class Tangle {
 public:
  Tangle(std::span<const Source> sources, std::span<const std::int32_t> alive, const Component& component, double d)
      : sources_(sources), alive_(alive), component_(component), d_(d) {
    list_strands();
  }

  // @return whether any strands cross
  bool find_crossings(BoxTree<double>& boxes) {
    boxes.leaves().resize(strands_.size());
    for (std::size_t i = 0; i < strands_.size(); ++i)
      boxes.leaves()[i] = box_of(sources_, strands_[i].a, strands_[i].b, strands_[i].source, d_);
    boxes.build();
    boxes.pairs([&](std::size_t i, std::size_t j) {
      if (strands_[i].next == j || strands_[j].next == i) return;
      intersect(sources_, d_, strands_[i], strands_[j], [&](Vec at, double on_i, double on_j) {
        crossings_.push_back({at, {std::uint32_t(i), std::uint32_t(j)}, {on_i, on_j}});
      });
    });
    return !crossings_.empty();
  }

  bool has_pivots() const { return strands_.size() != component_.pieces.size(); }

  bool passed(Vec place) const {
    const double limit = d_ - kPassed, square = limit > 0 ? limit * limit : 0;
    for (const std::int32_t s : alive_) {
      const Source& source = sources_[s];
      Vec away = place - source.at;
      if (!source.corner()) {
        const double along = std::clamp(dot(away, source.along), 0.0, source.length);
        away = away - along * source.along;
      }
      if (dot(away, away) < square) return true;
    }
    return false;
  }

  Vec middle(const Strand& strand) const {
    return strand.source == kPivot ? 0.5 * (strand.a + strand.b)
                                   : wavefront::middle(sources_[strand.source], strand.a, strand.b, d_);
  }

  bool loop_passed(std::size_t loop) const {
    const std::size_t begin = loop ? loop_ends_[loop - 1] : 0;
    std::size_t best = begin;
    for (std::size_t i = begin; i < loop_ends_[loop]; ++i)
      if (length(strands_[i].b - strands_[i].a) > length(strands_[best].b - strands_[best].a)) best = i;
    return strands_[best].source == kPivot || passed(middle(strands_[best]));
  }

  bool smooth(Component& kept);

 private:
  void list_strands() {
    strands_.reserve(component_.pieces.size() + 8);
    std::size_t begin = 0;
    for (const std::uint32_t end : component_.ends) {
      const std::uint32_t first = std::uint32_t(strands_.size());
      for (std::size_t i = begin; i < end; ++i) {
        const Piece& piece = component_.pieces[i];
        const Vec to = component_.pieces[i + 1 < end ? i + 1 : begin].from;
        const std::uint32_t here = std::uint32_t(strands_.size());
        if (piece.source == kPivot) {
          strands_.push_back({piece.from, piece.start.normal, std::int32_t(i), kPivot, here + 1});
          strands_.push_back({piece.start.normal, to, std::int32_t(i), kPivot, here + 2});
        } else {
          strands_.push_back({piece.from, to, std::int32_t(i), piece.source, here + 1});
        }
      }
      strands_.back().next = first;
      loop_ends_.push_back(std::uint32_t(strands_.size()));
      begin = end;
    }
  }

  bool arc(const Strand& s) const { return is_arc(sources_, s); }

  Vec travel(const Strand& s, Vec at) const {  // direction at a place of the strand
    if (!arc(s)) return s.b - s.a;
    return right_of(at - sources_[s.source].at);
  }

  void cut();
  bool judge(std::span<const std::uint32_t> loop, bool& keep) const;

  std::span<const Source> sources_;
  std::span<const std::int32_t> alive_;
  const Component& component_;
  double d_;
  std::vector<Strand> strands_;
  std::vector<std::uint32_t> loop_ends_;
  std::vector<Crossing> crossings_;
  std::vector<Fragment> fragments_;
};

// Cuts the strands at their crossings and lets the strands change partners there.
void Tangle::cut() {
  struct Cut {
    std::uint32_t strand, crossing;
    int side;
    double place;
  };
  std::vector<Cut> cuts;
  for (std::uint32_t c = 0; c < crossings_.size(); ++c)
    for (int side = 0; side < 2; ++side) cuts.push_back({crossings_[c].strand[side], c, side, crossings_[c].place[side]});
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) {
    if (a.strand != b.strand) return a.strand < b.strand;
    return a.place != b.place ? a.place < b.place : a.crossing < b.crossing;
  });
  std::vector<std::uint32_t> first_of(strands_.size());
  struct Ends {
    std::uint32_t in = 0, out = 0;
  };
  std::vector<std::array<Ends, 2>> ends(crossings_.size());
  std::size_t cut = 0;
  for (std::uint32_t s = 0; s < strands_.size(); ++s) {
    first_of[s] = std::uint32_t(fragments_.size());
    Fragment fragment{s, strands_[s].a, {}};
    for (; cut < cuts.size() && cuts[cut].strand == s; ++cut) {
      const Crossing& crossing = crossings_[cuts[cut].crossing];
      fragment.to = crossing.at;
      Ends& e = ends[cuts[cut].crossing][cuts[cut].side];
      e.in = std::uint32_t(fragments_.size());
      fragments_.push_back(fragment);
      e.out = std::uint32_t(fragments_.size());
      fragment = {s, crossing.at, {}};
      fragment.crossed = true;
    }
    fragment.to = strands_[s].b;
    fragments_.push_back(fragment);
  }
  for (std::uint32_t f = 0; f < fragments_.size(); ++f) fragments_[f].next = f + 1;
  for (std::uint32_t s = 0; s < strands_.size(); ++s) {
    const std::uint32_t last = s + 1 < strands_.size() ? first_of[s + 1] - 1 : std::uint32_t(fragments_.size() - 1);
    fragments_[last].next = first_of[strands_[s].next];
  }
  for (std::size_t c = 0; c < crossings_.size(); ++c) {
    const Strand &a = strands_[crossings_[c].strand[0]], &b = strands_[crossings_[c].strand[1]];
    const bool b_lies_left = cross(travel(a, crossings_[c].at), travel(b, crossings_[c].at)) > 0;
    for (int side = 0; side < 2; ++side) {
      Fragment& out = fragments_[ends[c][1 - side].out];
      fragments_[ends[c][side].in].next = ends[c][1 - side].out;
      out.before = strands_[crossings_[c].strand[side]].source;
      out.right_turn = (side == 0) != b_lies_left;
    }
  }
}

// @return false if it cannot tell
bool Tangle::judge(std::span<const std::uint32_t> loop, bool& keep) const {
  double total = 0, longest[2] = {-1, -1};
  std::uint32_t best[2] = {0, 0};
  bool corners_wrong = false;
  for (const std::uint32_t f : loop) {
    const Fragment& fragment = fragments_[f];
    const double l = length(fragment.to - fragment.from);
    total += l;
    corners_wrong |= strands_[fragment.strand].source == kPivot || fragment.right_turn;
    if (l > longest[0]) {
      longest[1] = longest[0], best[1] = best[0];
      longest[0] = l, best[0] = f;
    } else if (l > longest[1]) {
      longest[1] = l, best[1] = f;
    }
  }
  keep = false;
  if (total < kTiny) return true;
  for (int i = 0; i < (corners_wrong ? 1 : 2) && longest[i] > 0.25 * longest[0]; ++i) {
    const Fragment& fragment = fragments_[best[i]];
    Strand part = strands_[fragment.strand];
    part.a = fragment.from, part.b = fragment.to;
    const bool lives = part.source != kPivot && !passed(middle(part));
    if (i && lives != keep) return false;
    keep = lives;
  }
  return !(keep && corners_wrong);
}

bool Tangle::smooth(Component& kept) {
  cut();
  kept.pieces.reserve(component_.pieces.size());
  std::vector<std::uint32_t> loop;
  for (std::uint32_t f = 0; f < fragments_.size(); ++f) {
    if (fragments_[f].done) continue;
    loop.clear();
    for (std::uint32_t g = f; !fragments_[g].done; g = fragments_[g].next) {
      fragments_[g].done = true;
      loop.push_back(g);
    }
    bool keep = false;
    if (!judge(loop, keep)) return false;
    if (!keep) continue;
    for (const std::uint32_t g : loop) {
      const Fragment& fragment = fragments_[g];
      const Strand& strand = strands_[fragment.strand];
      Piece piece = component_.pieces[strand.piece];
      piece.from = fragment.from;
      if (fragment.crossed &&
          !meet(sources_[fragment.before], sources_[strand.source], fragment.from, d_, piece.start))
        return false;
      kept.pieces.push_back(piece);
    }
    kept.ends.push_back(std::uint32_t(kept.pieces.size()));
  }
  return true;
}

// One loop without pivots and crossings: the common case.
bool plainly_simple(std::span<const Source> sources, const Component& component, double d, BoxTree<double>& boxes) {
  const std::size_t n = component.pieces.size();
  if (component.ends.size() != 1) return false;
  const auto strand = [&](std::size_t i) {
    const Piece& piece = component.pieces[i];
    return Strand{piece.from, component.pieces[i + 1 < n ? i + 1 : 0].from, 0, piece.source, 0};
  };
  boxes.leaves().resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Strand s = strand(i);
    if (s.source == kPivot) return false;
    boxes.leaves()[i] = box_of(sources, s.a, s.b, s.source, d);
  }
  boxes.build();
  bool simple = true;
  boxes.pairs([&](std::size_t i, std::size_t j) {
    if (!simple || j == i + 1 || (i == 0 && j + 1 == n)) return;
    intersect(sources, d, strand(i), strand(j), [&](Vec, double, double) { simple = false; });
  });
  return simple;
}

}  // namespace

bool untangle(std::span<const Source> sources, std::span<const std::int32_t> alive, Component& component, double d,
              BoxTree<double>& boxes, std::vector<Component>& out) {
  if (component.ends.empty()) return true;
  if (plainly_simple(sources, component, d, boxes)) {
    double area = 0;  // by chords: arcs bulge into the area, which does not change the sign
    const Vec origin = component.pieces[0].from;
    for (std::size_t i = 1; i + 1 < component.pieces.size(); ++i)
      area += cross(component.pieces[i].from - origin, component.pieces[i + 1].from - origin);
    if (area > 0) out.push_back(std::move(component));
    return true;
  }
  Tangle tangle(sources, alive, component, d);
  if (!tangle.find_crossings(boxes)) {
    const bool simple = component.ends.size() == 1;
    if (simple && !tangle.has_pivots()) {
      regroup(sources, component, d, out);
      return true;
    }
    // Loops may have run past each other without crossing any more.
    Component kept;
    std::size_t begin = 0;
    for (std::size_t loop = 0; loop < component.ends.size(); begin = component.ends[loop++]) {
      if (tangle.loop_passed(loop)) continue;
      kept.pieces.insert(kept.pieces.end(), component.pieces.begin() + std::ptrdiff_t(begin),
                         component.pieces.begin() + component.ends[loop]);
      kept.ends.push_back(std::uint32_t(kept.pieces.size()));
    }
    for (const Piece& piece : kept.pieces)
      if (piece.source == kPivot) return false;
    if (kept.ends.size() == component.ends.size()) out.push_back(std::move(component));
    else if (!kept.ends.empty()) regroup(sources, kept, d, out);
    return true;
  }
  Component kept;
  if (!tangle.smooth(kept)) return false;
  if (!kept.ends.empty()) regroup(sources, kept, d, out);
  return true;
}

}  // namespace firn::slice::wavefront
