// Global deaths: where parts of the front that are no neighbours have run through each other.
//
// At every crossing the two strands change partners (Seifert's smoothing), which leaves closed loops that do
// not cross. Each loop lies wholly on the true offset or wholly in what the front has passed over, so the
// distance of one of its places from the sources decides for all of it.
#include <algorithm>
#include <array>
#include <utility>

#include "core/geometry/chains.h"
#include "core/slice/offset/wavefront_passed.h"
#include "core/slice/offset/wavefront_strand.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kTiny = 10.0;    // units: loops shorter than 1 um are dropped
constexpr double kPassed = 0.05;  // units: a place nearer than d - kPassed to a source has been passed
constexpr int kAbout =
    4;  // strands on either side of a crossing that are asked first whether they have passed
constexpr std::size_t kSmall = 64;  // strands

// Of a loop of strands: from one cut, or where it begins, to the next, or where it ends.
struct Part {
  std::uint32_t first, last;  // strands, the first and the last one in part
  Vec from, to;
  std::uint32_t next = 0;
  bool crossed = false;     // begins at a crossing (then `before` is the strand it comes from)
  bool right_turn = false;  // begins at a crossing by turning right: bounds passed area on its other side
  std::uint32_t before = 0;
  bool done = false;
};

struct Cut {
  std::uint32_t strand, crossing;
  int side;
  double place;
};

struct Ends {
  std::uint32_t in = 0, out = 0;
};

}  // namespace

class Untangler::Tangle {
 public:
  void begin(std::span<const Source> sources) {
    sources_ = sources;
    passed_by_.begin(sources);
  }

  // @return false if it cannot tell
  bool untangle(Component& component, double d, Components& out);

 private:
  // @return whether any strands cross
  bool find_crossings() {
    crossings_.clear();
    const bool alone = component_->ends.size() == 1;
    simple_ = component_->pivots.empty() && alone;
    if (!component_->pivots.empty()) {
      list_strands();
      find_in(StrandEdges{sources_, strands_.data(), d_});
      return !crossings_.empty();
    }
    list_runs(alone);
    find_in(PieceEdges{sources_, component_->pieces, alone ? nullptr : after_.data(), d_});
    if (crossings_.empty()) return false;
    pieces_as_strands();
    return true;
  }

  // Of pieces from `begin` to `end`, which cross nothing.
  bool loop_passed(std::size_t begin, std::size_t end) {
    const std::vector<Piece>& pieces = component_->pieces;
    Strand best;
    double longest = -1;
    const auto add = [&](Vec a, Vec b, std::int32_t source) {
      if (const double square = dot(b - a, b - a); square > longest)
        longest = square, best.a = a, best.b = b, best.source = source;
    };
    for (std::size_t i = begin; i < end; ++i) {
      const Vec a = pieces[i].from, b = pieces[i + 1 < end ? i + 1 : begin].from;
      if (pieces[i].pivot())
        add(a, component_->place_of(pieces[i]), kPivot), add(component_->place_of(pieces[i]), b, kPivot);
      else
        add(a, b, pieces[i].source);
    }
    return best.source == kPivot || passed(middle(best));
  }
  void list_runs(bool alone);
  void list_strands();
  void pieces_as_strands();
  Strand* room(std::size_t strands);
  template <class Edges>
  void find_in(const Edges& edges) {
    chains_.pairs(edges, [&](std::size_t i, std::size_t j) {
      if (edges.next(i) == j || edges.next(j) == i) return;
      intersect(sources_, d_, edges.strand(i), edges.strand(j), [&](Vec at, double on_i, double on_j) {
        crossings_.push_back({at, {std::uint32_t(i), std::uint32_t(j)}, {on_i, on_j}});
      });
    });
  }
  Vec middle(const Strand& strand) const {
    return strand.source == kPivot
               ? 0.5 * (strand.a + strand.b)
               : wavefront::middle(sources_[std::size_t(strand.source)], strand.a, strand.b, d_);
  }
  double limit() const { return std::max(0.0, d_ - kPassed); }
  bool passed(Vec place) { return passed_by_(place, limit()); }
  // What has passed over a loop mostly comes from beside one of its crossings; small loops mostly have been
  // passed.
  bool passed_beside(Vec place) const {
    return std::any_of(loop_.begin(), loop_.end(), [&](std::uint32_t p) {
      return parts_[p].crossed &&
             (passed_about(place, parts_[p].first) || passed_about(place, parts_[p].before));
    });
  }
  bool passed_about(Vec place, std::uint32_t strand) const {
    const double square = limit() * limit();
    const std::uint32_t end = std::uint32_t(std::min<std::size_t>(strands_.size(), strand + kAbout + 1));
    for (std::uint32_t s = strand > kAbout ? strand - kAbout : 0; s < end; ++s)
      if (strands_[s].source != kPivot &&
          square_distance(place, sources_[std::size_t(strands_[s].source)]) < square)
        return true;
    return false;
  }
  Vec travel(const Strand& s, Vec at) const {  // direction at a place of the strand
    return is_arc(sources_, s) ? right_of(at - sources_[std::size_t(s.source)].at) : s.b - s.a;
  }
  void cut();
  bool judge(bool& keep);
  bool smooth();
  bool drop_passed(Component& component, Components& out);

  std::span<const Source> sources_;
  const Component* component_ = nullptr;
  double d_ = 0;
  Chains chains_;
  bool simple_ = false;    // a single loop without pivots
  double twice_area_ = 0;  // then: by chords; arcs bulge into the area, which does not change its sign
  std::unique_ptr<Strand[]> room_;
  std::size_t room_size_ = 0;
  std::span<Strand> strands_;             // in it
  std::vector<std::uint32_t> after_;      // each piece, if no piece is a pivot and there are several loops
  std::vector<std::uint32_t> loop_ends_;  // strands
  std::vector<Crossing> crossings_;
  std::vector<Cut> cuts_;
  std::vector<Part> parts_;
  std::vector<std::array<Ends, 2>> ends_;  // of each crossing
  std::vector<std::uint32_t> loop_;        // parts
  PassedBy passed_by_;
  Components kept_;  // loops
  Regroup regroup_;
};

// Without pivots.
void Untangler::Tangle::list_runs(bool alone) {
  chains_.clear();
  const std::span<const Piece> pieces = component_->pieces;
  if (!alone) after_.resize(pieces.size());
  std::size_t begin = 0;
  double area = 0;
  for (const std::uint32_t end : component_->ends) {
    const Vec origin = pieces[begin].from;
    Vec from = origin;
    int last = Chains::kNone;
    for (std::size_t i = begin; i < end; ++i) {
      const Source& source = sources_[std::size_t(pieces[i].source)];
      const Vec to = i + 1 < end ? pieces[i + 1].from : origin;
      const int run = run_of(source, from, to, d_);
      if (Chains::begins(run, last)) chains_.begin(std::uint32_t(i), run, last);
      last = run;
      area += cross(from - origin, to - origin);
      from = to;
      if (!alone) after_[i] = std::uint32_t(i + 1);
    }
    if (!alone) after_[end - 1] = std::uint32_t(begin);
    begin = end;
  }
  chains_.end(std::uint32_t(pieces.size()));
  twice_area_ = area;
}

Strand* Untangler::Tangle::room(std::size_t strands) {
  if (room_size_ < strands) {
    room_size_ = 2 * strands;
    room_ = std::make_unique_for_overwrite<Strand[]>(room_size_);
  }
  return room_.get();
}

// Without pivots.
void Untangler::Tangle::pieces_as_strands() {
  const std::span<const Piece> pieces = component_->pieces;
  Strand* const strands = room(pieces.size());
  strands_ = {strands, pieces.size()};
  loop_ends_.assign(component_->ends.begin(), component_->ends.end());
  std::uint32_t i = 0;
  for (const std::uint32_t end : loop_ends_) {
    const std::uint32_t begin = i;
    for (; i < end; ++i) {
      const std::uint32_t next = i + 1 < end ? i + 1 : begin;
      strands[i] = {pieces[i].from, pieces[next].from, std::int32_t(i), pieces[i].source, next};
    }
  }
}

void Untangler::Tangle::list_strands() {
  loop_ends_.clear();
  chains_.clear();
  Strand *const strands = room(2 * component_->pieces.size()), *strand = strands;
  std::uint32_t count = 0;
  const Piece* const pieces = component_->pieces.data();
  std::size_t begin = 0;
  for (const std::uint32_t end : component_->ends) {
    const std::uint32_t first = count;
    int last = Chains::kNone;
    const auto add = [&](Vec a, Vec b, const Piece* piece, std::int32_t source, int run) {
      strand->a = a, strand->b = b;
      strand->piece = std::int32_t(piece - pieces), strand->source = source, strand->next = count + 1;
      ++strand;
      if (Chains::begins(run, last)) chains_.begin(count, run, last);
      last = run;
      ++count;
    };
    Vec from = pieces[begin].from;
    for (const Piece *piece = pieces + begin, *const stop = pieces + end; piece != stop; ++piece) {
      const Vec to = piece + 1 != stop ? piece[1].from : pieces[begin].from;
      if (piece->pivot()) {
        const Vec pivot = component_->place_of(*piece);
        add(from, pivot, piece, kPivot, Chains::run_of(pivot - from));
        add(pivot, to, piece, kPivot, Chains::run_of(to - pivot));
      } else {
        add(from, to, piece, piece->source, run_of(sources_[std::size_t(piece->source)], from, to, d_));
      }
      from = to;
    }
    strand[-1].next = first;
    loop_ends_.push_back(count);
    begin = end;
  }
  chains_.end(count);
  strands_ = {strands, count};
}

// Cuts the strands at their crossings and lets the strands change partners there.
void Untangler::Tangle::cut() {
  cuts_.clear();
  for (std::uint32_t c = 0; c < crossings_.size(); ++c)
    for (int side = 0; side < 2; ++side)
      cuts_.push_back({crossings_[c].strand[side], c, side, crossings_[c].place[side]});
  std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
    if (a.strand != b.strand) return a.strand < b.strand;
    return a.place != b.place ? a.place < b.place : a.crossing < b.crossing;
  });
  ends_.resize(crossings_.size());
  parts_.clear();
  std::size_t cut = 0;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : loop_ends_) {
    const std::uint32_t head = std::uint32_t(parts_.size());
    Part part{begin, begin, strands_[begin].a, {}};
    for (; cut < cuts_.size() && cuts_[cut].strand < end; ++cut) {
      const Crossing& crossing = crossings_[cuts_[cut].crossing];
      part.last = cuts_[cut].strand, part.to = crossing.at;
      Ends& e = ends_[cuts_[cut].crossing][std::size_t(cuts_[cut].side)];
      e.in = std::uint32_t(parts_.size());
      parts_.push_back(part);
      e.out = std::uint32_t(parts_.size());
      part = {part.last, part.last, crossing.at, {}};
      part.crossed = true;
    }
    part.last = end - 1, part.to = strands_[end - 1].b, part.next = head;
    parts_.push_back(part);
    begin = end;
  }
  for (std::size_t c = 0; c < crossings_.size(); ++c) {
    const Strand &a = strands_[crossings_[c].strand[0]], &b = strands_[crossings_[c].strand[1]];
    const bool b_lies_left = cross(travel(a, crossings_[c].at), travel(b, crossings_[c].at)) > 0;
    for (int side = 0; side < 2; ++side) {
      Part& out = parts_[ends_[c][1 - side].out];
      parts_[ends_[c][side].in].next = ends_[c][1 - side].out;
      out.before = crossings_[c].strand[side];
      out.right_turn = (side == 0) != b_lies_left;
    }
  }
}

// Whether loop_ is kept. @return false if it cannot tell
bool Untangler::Tangle::judge(bool& keep) {
  double total = 0, longest[2] = {-1, -1};  // squares
  Strand best[2];
  bool corners_wrong = false;
  std::size_t strands = 0;
  const auto look = [&](Vec a, Vec b, const Strand& strand) {
    const Vec way = b - a;
    const double square = dot(way, way);
    if (total < kTiny) total += std::abs(way.x) + std::abs(way.y);
    corners_wrong |= strand.source == kPivot;
    if (!(square > longest[1])) return;
    const int rank = square > longest[0] ? 0 : 1;
    if (rank == 0) longest[1] = longest[0], best[1] = best[0];
    longest[rank] = square;
    best[rank].a = a, best[rank].b = b, best[rank].source = strand.source;
  };
  for (const std::uint32_t p : loop_) {
    const Part& part = parts_[p];
    corners_wrong |= part.right_turn;
    strands += part.last - part.first + 1;
    const Strand *const first = &strands_[part.first], *const last = &strands_[part.last];
    look(part.from, first == last ? part.to : first->b, *first);
    for (const Strand* s = first + 1; s < last; ++s) look(s->a, s->b, *s);
    if (first != last) look(last->a, part.to, *last);
  }
  keep = false;
  if (total < kTiny) return true;
  for (int i = 0; i < (corners_wrong ? 1 : 2) && longest[i] > 0.0625 * longest[0]; ++i) {
    const Vec place = middle(best[i]);
    const bool lives =
        best[i].source != kPivot && !(strands <= kSmall && passed_beside(place)) && !passed(place);
    if (i && lives != keep) return false;
    keep = lives;
  }
  return !(keep && corners_wrong);
}

bool Untangler::Tangle::smooth() {
  cut();
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    if (parts_[p].done) continue;
    loop_.clear();
    for (std::uint32_t q = p; !parts_[q].done; q = parts_[q].next) {
      parts_[q].done = true;
      loop_.push_back(q);
    }
    bool keep = false;
    if (!judge(keep)) return false;
    if (!keep) continue;
    Component& loop = kept_.add();
    for (const std::uint32_t q : loop_) {  // without pivots: a piece for each strand
      const Part& part = parts_[q];
      const std::size_t first = loop.pieces.size();
      const auto pieces = component_->pieces.begin() + strands_[part.first].piece;
      loop.pieces.insert(loop.pieces.end(), pieces, pieces + (part.last - part.first + 1));
      Piece& piece = loop.pieces[first];
      piece.from = part.from;
      if (part.crossed && !meet(sources_[std::size_t(strands_[part.before].source)],
                                sources_[std::size_t(piece.source)], part.from, d_, piece.start))
        return false;
    }
    loop.ends.push_back(std::uint32_t(loop.pieces.size()));
  }
  return true;
}

// Loops may have run past each other without crossing any more. @return false if it cannot tell
bool Untangler::Tangle::drop_passed(Component& component, Components& out) {
  const auto each_loop = [&](auto&& f) {
    std::uint32_t begin = 0;
    for (const std::uint32_t end : component.ends) f(std::exchange(begin, end), end);
  };
  loop_.clear();  // first pieces of those that stay
  each_loop([&](std::uint32_t begin, std::uint32_t end) {
    if (!loop_passed(begin, end)) loop_.push_back(begin);
  });
  auto stays = loop_.begin();
  bool pivots = false;
  each_loop([&](std::uint32_t begin, std::uint32_t end) {
    if (stays == loop_.end() || *stays != begin) return;
    ++stays;
    for (std::uint32_t i = begin; i < end; ++i) pivots |= component.pieces[i].pivot();
    if (loop_.size() == component.ends.size()) return;
    Component& loop = kept_.add();
    loop.pieces.assign(component.pieces.begin() + begin, component.pieces.begin() + end);
    loop.ends.push_back(std::uint32_t(loop.pieces.size()));
  });
  if (pivots) return false;
  if (loop_.size() == component.ends.size())
    out.take(component);
  else
    regroup_(sources_, kept_, d_, out);
  return true;
}

bool Untangler::Tangle::untangle(Component& component, double d, Components& out) {
  component_ = &component, d_ = d;
  kept_.clear();
  if (find_crossings()) {
    if (!smooth()) return false;
    regroup_(sources_, kept_, d, out);
    return true;
  }
  if (!simple_) return drop_passed(component, out);
  if (twice_area_ > 0) out.take(component);
  return true;
}

Untangler::Untangler() : tangle_(std::make_unique<Tangle>()) {}
Untangler::~Untangler() = default;

void Untangler::begin(std::span<const Source> sources) { tangle_->begin(sources); }

bool Untangler::operator()(Component& component, double d, Components& out) {
  if (component.ends.empty()) return true;
  return tangle_->untangle(component, d, out);
}

}  // namespace firn::slice::wavefront
