// Global deaths: where parts of the front that are no neighbours have run through each other.
//
// At every crossing the two strands change partners (Seifert's smoothing), which leaves closed loops that do not cross.
// Each loop lies wholly on the true offset or wholly in what the front has passed over, so the distance of one of its
// places from the sources decides for all of it.
#include <algorithm>
#include <array>

#include "core/slice/chains.h"
#include "core/slice/wavefront_passed.h"
#include "core/slice/wavefront_strand.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kTiny = 10.0;    // units: loops shorter than 1 um are dropped
constexpr double kPassed = 0.05;  // units: a place nearer than d - kPassed to a source has been passed
constexpr int kAsked = 2;         // so many places are held against every source before the sources are listed in blocks
constexpr int kAbout = 4;         // strands on either side of a crossing that are asked first whether they have passed
constexpr std::size_t kSmall = 64;  // fragments

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
  void take(std::span<const Source> sources, std::span<const std::int32_t> died, const Component& component, double d) {
    sources_ = sources, died_ = died, component_ = &component, d_ = d;
    crossings_.clear();
    passed_by_.clear();
    asked_ = 0;
  }

  // @return whether any strands cross
  bool find_crossings() {
    simple_ = component_->ends.size() == 1 && list_runs();
    if (simple_) {
      find_in(PieceEdges{sources_, component_->pieces, d_});
      if (crossings_.empty()) return false;
      list_strands();
    } else {
      list_strands();
      find_in(StrandEdges{sources_, strands_.data(), d_});
    }
    return !crossings_.empty();
  }

  bool simple() const { return simple_; }  // a single loop without pivots
  double twice_area() const { return twice_area_; }  // then: by chords; arcs bulge into the area, which does not change its sign

  bool loop_passed(std::size_t loop) {
    const std::size_t begin = loop ? loop_ends_[loop - 1] : 0;
    std::size_t best = begin;
    double longest = -1;
    for (std::size_t i = begin; i < loop_ends_[loop]; ++i) {
      const Vec way = strands_[i].b - strands_[i].a;
      if (const double square = dot(way, way); square > longest) longest = square, best = i;
    }
    return strands_[best].source == kPivot || passed(middle(strands_[best]));
  }

  // @return false if it cannot tell
  bool smooth(Component& kept);

 private:
  bool list_runs();
  void list_strands();
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
    return strand.source == kPivot ? 0.5 * (strand.a + strand.b)
                                   : wavefront::middle(sources_[strand.source], strand.a, strand.b, d_);
  }
  double limit() const {
    const double limit = d_ - kPassed;
    return limit > 0 ? limit * limit : 0;
  }
  double square_distance(Vec place, const Source& source) const {
    Vec away = place - source.at;
    if (!source.corner()) away = away - std::clamp(dot(away, source.along), 0.0, source.length) * source.along;
    return dot(away, away);
  }
  bool passed(Vec place) {
    const double square = limit();
    if (++asked_ <= kAsked)
      return any_source([&](const Source& source) { return square_distance(place, source) < square; });
    if (passed_by_.empty()) any_source([&](const Source& source) { return passed_by_.add(source), false; });
    return passed_by_(place, std::max(0.0, d_ - kPassed));
  }
  // Of all that the component had before it moved.
  template <class F>
  bool any_source(F&& f) const {
    return std::any_of(component_->pieces.begin(), component_->pieces.end(),
                       [&](const Piece& p) { return p.source != kPivot && f(sources_[std::size_t(p.source)]); }) ||
           std::any_of(died_.begin(), died_.end(), [&](std::int32_t s) { return f(sources_[std::size_t(s)]); });
  }
  // What has passed over a loop mostly comes from beside one of its crossings; small loops mostly have been passed.
  bool passed_beside(Vec place) const {
    if (loop_.size() > kSmall) return false;
    return std::any_of(loop_.begin(), loop_.end(), [&](std::uint32_t f) {
      return fragments_[f].crossed && (passed_about(place, fragments_[f].strand) || passed_about(place, fragments_[f].before));
    });
  }
  bool passed_about(Vec place, std::uint32_t strand) const {
    const double square = limit();
    const std::uint32_t end = std::uint32_t(std::min<std::size_t>(strands_.size(), strand + kAbout + 1));
    for (std::uint32_t s = strand > kAbout ? strand - kAbout : 0; s < end; ++s)
      if (strands_[s].source != kPivot && square_distance(place, sources_[strands_[s].source]) < square) return true;
    return false;
  }
  Vec travel(const Strand& s, Vec at) const {  // direction at a place of the strand
    return is_arc(sources_, s) ? right_of(at - sources_[s.source].at) : s.b - s.a;
  }
  // An arc of at most half a turn whose ends go the same way goes that way all along, and one of less than a quarter turns
  // along one axis at most; one that has died may not end on its circle.
  int run_of_arc(Vec a, Vec b) const {
    const double square = d_ * d_;
    if (std::abs(dot(a, a) - square) >= d_ || std::abs(dot(b, b) - square) >= d_ || cross(a, b) > 0) return Chains::kBent;
    const int from = Chains::run_of(right_of(a)), turned = from ^ Chains::run_of(right_of(b));
    if (turned == 0) return from;
    return dot(a, b) > 0 ? from | turned << 2 : int(Chains::kBent);
  }
  void cut();
  bool judge(bool& keep);

  std::span<const Source> sources_;
  std::span<const std::int32_t> died_;
  const Component* component_ = nullptr;
  double d_ = 0;
  Chains chains_;
  bool simple_ = false;
  double twice_area_ = 0;
  std::unique_ptr<Strand[]> room_;
  std::size_t room_size_ = 0;
  std::span<Strand> strands_;  // in it
  std::vector<std::uint32_t> loop_ends_;
  std::vector<Crossing> crossings_;
  std::vector<Cut> cuts_;
  std::vector<Fragment> fragments_;
  std::vector<std::uint32_t> first_of_;        // fragment of each strand
  std::vector<std::array<Ends, 2>> ends_;      // of each crossing
  std::vector<std::uint32_t> loop_;
  PassedBy passed_by_;
  int asked_ = 0;  // whether it has been passed: so many places of the component
};

// Of a single loop. @return false if it has pivots
bool Untangler::Tangle::list_runs() {
  chains_.clear();
  const std::span<const Piece> pieces = component_->pieces;
  const Vec origin = pieces[0].from;
  Vec from = origin;
  double area = 0;
  int last = Chains::kNone;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].source == kPivot) return false;
    const Source& source = sources_[std::size_t(pieces[i].source)];
    const Vec to = i + 1 < pieces.size() ? pieces[i + 1].from : origin;
    const int run = source.corner() ? run_of_arc(from - source.at, to - source.at) : Chains::run_of(to - from);
    if (Chains::begins(run, last)) chains_.begin(std::uint32_t(i), run, last);
    last = run;
    area += cross(from - origin, to - origin);
    from = to;
  }
  chains_.end(std::uint32_t(pieces.size()));
  twice_area_ = area;
  return true;
}

void Untangler::Tangle::list_strands() {
  loop_ends_.clear();
  chains_.clear();
  if (room_size_ < 2 * component_->pieces.size()) {
    room_size_ = 2 * component_->pieces.size();
    room_ = std::make_unique_for_overwrite<Strand[]>(room_size_);
  }
  strands_ = {room_.get(), room_size_};
  Strand* strand = strands_.data();
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
      if (piece->source == kPivot) {
        const Vec pivot = piece->start.normal;
        add(from, pivot, piece, kPivot, Chains::run_of(pivot - from));
        add(pivot, to, piece, kPivot, Chains::run_of(to - pivot));
      } else {
        const Source& source = sources_[std::size_t(piece->source)];
        add(from, to, piece, piece->source, source.corner() ? run_of_arc(from - source.at, to - source.at) : Chains::run_of(to - from));
      }
      from = to;
    }
    strand[-1].next = first;
    loop_ends_.push_back(count);
    begin = end;
  }
  chains_.end(count);
  strands_ = strands_.first(count);
}

// Cuts the strands at their crossings and lets the strands change partners there.
void Untangler::Tangle::cut() {
  cuts_.clear();
  for (std::uint32_t c = 0; c < crossings_.size(); ++c)
    for (int side = 0; side < 2; ++side) cuts_.push_back({crossings_[c].strand[side], c, side, crossings_[c].place[side]});
  std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
    if (a.strand != b.strand) return a.strand < b.strand;
    return a.place != b.place ? a.place < b.place : a.crossing < b.crossing;
  });
  first_of_.resize(strands_.size());
  ends_.resize(crossings_.size());
  fragments_.clear();
  std::size_t cut = 0;
  for (std::uint32_t s = 0; s < strands_.size(); ++s) {
    first_of_[s] = std::uint32_t(fragments_.size());
    Fragment fragment{s, strands_[s].a, {}};
    for (; cut < cuts_.size() && cuts_[cut].strand == s; ++cut) {
      const Crossing& crossing = crossings_[cuts_[cut].crossing];
      fragment.to = crossing.at;
      Ends& e = ends_[cuts_[cut].crossing][cuts_[cut].side];
      e.in = std::uint32_t(fragments_.size());
      fragment.next = e.in + 1;
      fragments_.push_back(fragment);
      e.out = std::uint32_t(fragments_.size());
      fragment = {s, crossing.at, {}};
      fragment.crossed = true;
    }
    fragment.to = strands_[s].b;
    fragments_.push_back(fragment);
  }
  for (std::uint32_t s = 0; s < strands_.size(); ++s) {
    const std::uint32_t last = s + 1 < strands_.size() ? first_of_[s + 1] - 1 : std::uint32_t(fragments_.size() - 1);
    fragments_[last].next = first_of_[strands_[s].next];
  }
  for (std::size_t c = 0; c < crossings_.size(); ++c) {
    const Strand &a = strands_[crossings_[c].strand[0]], &b = strands_[crossings_[c].strand[1]];
    const bool b_lies_left = cross(travel(a, crossings_[c].at), travel(b, crossings_[c].at)) > 0;
    for (int side = 0; side < 2; ++side) {
      Fragment& out = fragments_[ends_[c][1 - side].out];
      fragments_[ends_[c][side].in].next = ends_[c][1 - side].out;
      out.before = crossings_[c].strand[side];
      out.right_turn = (side == 0) != b_lies_left;
    }
  }
}

// Whether loop_ is kept. @return false if it cannot tell
bool Untangler::Tangle::judge(bool& keep) {
  double total = 0, longest[2] = {-1, -1};  // squares
  std::uint32_t best[2] = {0, 0};
  bool corners_wrong = false;
  for (const std::uint32_t f : loop_) {
    const Fragment& fragment = fragments_[f];
    const Vec way = fragment.to - fragment.from;
    const double square = dot(way, way);
    total += std::abs(way.x) + std::abs(way.y);
    corners_wrong |= strands_[fragment.strand].source == kPivot || fragment.right_turn;
    if (square > longest[0]) {
      longest[1] = longest[0], best[1] = best[0];
      longest[0] = square, best[0] = f;
    } else if (square > longest[1]) {
      longest[1] = square, best[1] = f;
    }
  }
  keep = false;
  if (total < kTiny) return true;
  for (int i = 0; i < (corners_wrong ? 1 : 2) && longest[i] > 0.0625 * longest[0]; ++i) {
    const Fragment& fragment = fragments_[best[i]];
    Strand part = strands_[fragment.strand];
    part.a = fragment.from, part.b = fragment.to;
    const Vec place = middle(part);
    const bool lives = part.source != kPivot && !passed_beside(place) && !passed(place);
    if (i && lives != keep) return false;
    keep = lives;
  }
  return !(keep && corners_wrong);
}

bool Untangler::Tangle::smooth(Component& kept) {
  cut();
  kept.pieces.reserve(component_->pieces.size());
  for (std::uint32_t f = 0; f < fragments_.size(); ++f) {
    if (fragments_[f].done) continue;
    loop_.clear();
    for (std::uint32_t g = f; !fragments_[g].done; g = fragments_[g].next) {
      fragments_[g].done = true;
      loop_.push_back(g);
    }
    bool keep = false;
    if (!judge(keep)) return false;
    if (!keep) continue;
    for (const std::uint32_t g : loop_) {
      const Fragment& fragment = fragments_[g];
      const Strand& strand = strands_[fragment.strand];
      Piece& piece = kept.pieces.emplace_back(component_->pieces[strand.piece]);
      piece.from = fragment.from;
      if (fragment.crossed && !meet(sources_[strands_[fragment.before].source], sources_[strand.source], fragment.from, d_, piece.start))
        return false;
    }
    kept.ends.push_back(std::uint32_t(kept.pieces.size()));
  }
  return true;
}

Untangler::Untangler() : tangle_(std::make_unique<Tangle>()) {}
Untangler::~Untangler() = default;

bool Untangler::operator()(std::span<const Source> sources, std::span<const std::int32_t> died, Component& component,
                           double d, Components& out) {
  if (component.ends.empty()) return true;
  Tangle& tangle = *tangle_;
  tangle.take(sources, died, component, d);
  Component kept;
  if (tangle.find_crossings()) {
    if (!tangle.smooth(kept)) return false;
    if (!kept.ends.empty()) regroup(sources, kept, d, out);
    return true;
  }
  if (tangle.simple()) {
    if (tangle.twice_area() > 0) out.take(component);
    return true;
  }
  // Loops may have run past each other without crossing any more.
  std::size_t begin = 0;
  for (std::size_t loop = 0; loop < component.ends.size(); begin = component.ends[loop++]) {
    if (tangle.loop_passed(loop)) continue;
    kept.pieces.insert(kept.pieces.end(), component.pieces.begin() + std::ptrdiff_t(begin),
                       component.pieces.begin() + component.ends[loop]);
    kept.ends.push_back(std::uint32_t(kept.pieces.size()));
  }
  for (const Piece& piece : kept.pieces)
    if (piece.source == kPivot) return false;
  if (kept.ends.size() == component.ends.size()) out.take(component);
  else if (!kept.ends.empty()) regroup(sources, kept, d, out);
  return true;
}

}  // namespace firn::slice::wavefront
