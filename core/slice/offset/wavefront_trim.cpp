// Split events and self-intersection trimming: removes the invalid loops where parts of the wavefront that
// are not adjacent have passed through each other.
//
// At every crossing the two arcs exchange their successors (Seifert smoothing), which leaves closed loops
// without crossings. Each loop lies entirely on the exact offset or entirely in the area that has been swept,
// so the distance of one of its points from the sites decides for all of it.
#include <algorithm>
#include <array>
#include <utility>

#include "core/geometry/monotone_chains.h"
#include "core/slice/offset/site_index.h"
#include "core/slice/offset/wavefront_arcs.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kTiny = 10.0;      // units: loops shorter than 1 um are dropped
constexpr double kSwept = 0.05;     // units: a point nearer than d - kSwept to a site has been swept
constexpr int kAbout = 4;           // arcs on either side of a crossing that are tested first
constexpr std::size_t kSmall = 64;  // arcs

// Part of a loop of arcs between two consecutive cuts, or the ends of the loop.
struct Part {
  std::uint32_t first, last;  // arcs; the first and the last one belong to it in part
  geometry::Vec from, to;
  std::uint32_t next = 0;
  bool crossed = false;     // begins at a crossing (then `before` is the arc it comes from)
  bool right_turn = false;  // begins at a crossing with a right turn: it bounds swept area on its other side
  std::uint32_t before = 0;
  bool done = false;
};

struct Cut {
  std::uint32_t arc, crossing;
  int side;
  double place;
};

struct Ends {
  std::uint32_t in = 0, out = 0;
};

}  // namespace

class SelfIntersectionTrimmer::Trimming {
 public:
  void begin(std::span<const Site> sites) {
    sites_ = sites;
    site_index_.begin(sites);
  }

  // @return false if the result is ambiguous
  bool trim(Component& component, double d, Components& out);

 private:
  // @return whether any arcs cross
  bool find_crossings() {
    crossings_.clear();
    const bool alone = component_->ends.size() == 1;
    simple_ = component_->pivots.empty() && alone;
    if (!component_->pivots.empty()) {
      list_arcs();
      find_in(ArcEdges{sites_, arcs_.data(), d_});
      return !crossings_.empty();
    }
    list_runs(alone);
    find_in(LoopEdges{sites_, component_->edges, alone ? nullptr : after_.data(), d_});
    if (crossings_.empty()) return false;
    edges_as_arcs();
    return true;
  }

  // Returns whether the loop of edges [begin, end), which has no crossings, has been swept.
  bool loop_swept(std::size_t begin, std::size_t end) {
    const std::vector<WavefrontEdge>& edges = component_->edges;
    DirectedArc best;
    double longest = -1;
    const auto add = [&](geometry::Vec a, geometry::Vec b, std::int32_t site) {
      if (const double square = dot(b - a, b - a); square > longest) {
        longest = square;
        best.a = a;
        best.b = b;
        best.site = site;
      }
    };
    for (std::size_t i = begin; i < end; ++i) {
      const geometry::Vec a = edges[i].from, b = edges[i + 1 < end ? i + 1 : begin].from;
      if (edges[i].pivot()) {
        add(a, component_->place_of(edges[i]), kPivot);
        add(component_->place_of(edges[i]), b, kPivot);
      } else {
        add(a, b, edges[i].site);
      }
    }
    return best.site == kPivot || is_swept(middle(best));
  }
  void list_runs(bool alone);
  void list_arcs();
  void edges_as_arcs();
  DirectedArc* room(std::size_t arcs);
  template <class Edges>
  void find_in(const Edges& edges) {
    chains_.pairs(edges, [&](std::size_t i, std::size_t j) {
      if (edges.next(i) == j || edges.next(j) == i) return;
      intersect(sites_, d_, edges.arc(i), edges.arc(j), [&](geometry::Vec at, double on_i, double on_j) {
        crossings_.push_back({at, {std::uint32_t(i), std::uint32_t(j)}, {on_i, on_j}});
      });
    });
  }
  geometry::Vec middle(const DirectedArc& arc) const {
    return arc.site == kPivot ? 0.5 * (arc.a + arc.b)
                              : wavefront::middle(sites_[std::size_t(arc.site)], arc.a, arc.b, d_);
  }
  double limit() const { return std::max(0.0, d_ - kSwept); }
  bool is_swept(geometry::Vec place) { return site_index_(place, limit()); }
  // The sites that have swept a loop are usually near one of its crossings; small loops usually have been
  // swept.
  bool swept_beside(geometry::Vec place) const {
    return std::any_of(loop_.begin(), loop_.end(), [&](std::uint32_t p) {
      return parts_[p].crossed &&
             (swept_about(place, parts_[p].first) || swept_about(place, parts_[p].before));
    });
  }
  bool swept_about(geometry::Vec place, std::uint32_t arc) const {
    const double square = limit() * limit();
    const std::uint32_t end = std::uint32_t(std::min<std::size_t>(arcs_.size(), arc + kAbout + 1));
    for (std::uint32_t s = arc > kAbout ? arc - kAbout : 0; s < end; ++s)
      if (arcs_[s].site != kPivot && square_distance(place, sites_[std::size_t(arcs_[s].site)]) < square)
        return true;
    return false;
  }
  geometry::Vec travel(const DirectedArc& s, geometry::Vec at) const {  // direction at a point of the arc
    return is_circular(sites_, s) ? right_of(at - sites_[std::size_t(s.site)].at) : s.b - s.a;
  }
  void cut();
  bool judge(bool& keep);
  bool smooth();
  bool drop_swept(Component& component, Components& out);

  std::span<const Site> sites_;
  const Component* component_ = nullptr;
  double d_ = 0;
  geometry::MonotoneChains chains_;
  bool simple_ = false;    // one loop without pivots
  double twice_area_ = 0;  // of the chords, if simple_; arcs bulge into the area, which keeps its sign
  std::unique_ptr<DirectedArc[]> room_;
  std::size_t room_size_ = 0;
  std::span<DirectedArc> arcs_;           // in room_
  std::vector<std::uint32_t> after_;      // successors of edges, if there are no pivots and several loops
  std::vector<std::uint32_t> loop_ends_;  // arcs
  std::vector<Crossing> crossings_;
  std::vector<Cut> cuts_;
  std::vector<Part> parts_;
  std::vector<std::array<Ends, 2>> ends_;  // of each crossing
  std::vector<std::uint32_t> loop_;        // parts
  SiteIndex site_index_;
  Components kept_;  // loops
  HoleNesting nest_holes_;
};

// Without pivots.
void SelfIntersectionTrimmer::Trimming::list_runs(bool alone) {
  chains_.clear();
  const std::span<const WavefrontEdge> edges = component_->edges;
  if (!alone) after_.resize(edges.size());
  std::size_t begin = 0;
  double area = 0;
  for (const std::uint32_t end : component_->ends) {
    const geometry::Vec origin = edges[begin].from;
    geometry::Vec from = origin;
    int last = geometry::MonotoneChains::kNone;
    for (std::size_t i = begin; i < end; ++i) {
      const Site& site = sites_[std::size_t(edges[i].site)];
      const geometry::Vec to = i + 1 < end ? edges[i + 1].from : origin;
      const int run = run_of(site, from, to, d_);
      if (geometry::MonotoneChains::begins(run, last)) chains_.begin(std::uint32_t(i), run, last);
      last = run;
      area += cross(from - origin, to - origin);
      from = to;
      if (!alone) after_[i] = std::uint32_t(i + 1);
    }
    if (!alone) after_[end - 1] = std::uint32_t(begin);
    begin = end;
  }
  chains_.end(std::uint32_t(edges.size()));
  twice_area_ = area;
}

DirectedArc* SelfIntersectionTrimmer::Trimming::room(std::size_t arcs) {
  if (room_size_ < arcs) {
    room_size_ = 2 * arcs;
    room_ = std::make_unique_for_overwrite<DirectedArc[]>(room_size_);
  }
  return room_.get();
}

// Without pivots.
void SelfIntersectionTrimmer::Trimming::edges_as_arcs() {
  const std::span<const WavefrontEdge> edges = component_->edges;
  DirectedArc* const arcs = room(edges.size());
  arcs_ = {arcs, edges.size()};
  loop_ends_.assign(component_->ends.begin(), component_->ends.end());
  std::uint32_t i = 0;
  for (const std::uint32_t end : loop_ends_) {
    const std::uint32_t begin = i;
    for (; i < end; ++i) {
      const std::uint32_t next = i + 1 < end ? i + 1 : begin;
      arcs[i] = {edges[i].from, edges[next].from, std::int32_t(i), edges[i].site, next};
    }
  }
}

void SelfIntersectionTrimmer::Trimming::list_arcs() {
  loop_ends_.clear();
  chains_.clear();
  DirectedArc *const arcs = room(2 * component_->edges.size()), *arc = arcs;
  std::uint32_t count = 0;
  const WavefrontEdge* const edges = component_->edges.data();
  std::size_t begin = 0;
  for (const std::uint32_t end : component_->ends) {
    const std::uint32_t first = count;
    int last = geometry::MonotoneChains::kNone;
    const auto add = [&](geometry::Vec a, geometry::Vec b, const WavefrontEdge* edge, std::int32_t site,
                         int run) {
      arc->a = a;
      arc->b = b;
      arc->edge = std::int32_t(edge - edges);
      arc->site = site;
      arc->next = count + 1;
      ++arc;
      if (geometry::MonotoneChains::begins(run, last)) chains_.begin(count, run, last);
      last = run;
      ++count;
    };
    geometry::Vec from = edges[begin].from;
    for (const WavefrontEdge *edge = edges + begin, *const stop = edges + end; edge != stop; ++edge) {
      const geometry::Vec to = edge + 1 != stop ? edge[1].from : edges[begin].from;
      if (edge->pivot()) {
        const geometry::Vec pivot = component_->place_of(*edge);
        add(from, pivot, edge, kPivot, geometry::MonotoneChains::run_of(pivot - from));
        add(pivot, to, edge, kPivot, geometry::MonotoneChains::run_of(to - pivot));
      } else {
        add(from, to, edge, edge->site, run_of(sites_[std::size_t(edge->site)], from, to, d_));
      }
      from = to;
    }
    arc[-1].next = first;
    loop_ends_.push_back(count);
    begin = end;
  }
  chains_.end(count);
  arcs_ = {arcs, count};
}

// Cuts the arcs at their crossings and lets the arcs change partners there.
void SelfIntersectionTrimmer::Trimming::cut() {
  cuts_.clear();
  for (std::uint32_t c = 0; c < crossings_.size(); ++c)
    for (int side = 0; side < 2; ++side)
      cuts_.push_back({crossings_[c].arc[side], c, side, crossings_[c].place[side]});
  std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
    if (a.arc != b.arc) return a.arc < b.arc;
    return a.place != b.place ? a.place < b.place : a.crossing < b.crossing;
  });
  ends_.resize(crossings_.size());
  parts_.clear();
  std::size_t cut = 0;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : loop_ends_) {
    const std::uint32_t head = std::uint32_t(parts_.size());
    Part part{begin, begin, arcs_[begin].a, {}};
    for (; cut < cuts_.size() && cuts_[cut].arc < end; ++cut) {
      const Crossing& crossing = crossings_[cuts_[cut].crossing];
      part.last = cuts_[cut].arc;
      part.to = crossing.at;
      Ends& e = ends_[cuts_[cut].crossing][std::size_t(cuts_[cut].side)];
      e.in = std::uint32_t(parts_.size());
      parts_.push_back(part);
      e.out = std::uint32_t(parts_.size());
      part = {part.last, part.last, crossing.at, {}};
      part.crossed = true;
    }
    part.last = end - 1;
    part.to = arcs_[end - 1].b;
    part.next = head;
    parts_.push_back(part);
    begin = end;
  }
  for (std::size_t c = 0; c < crossings_.size(); ++c) {
    const DirectedArc &a = arcs_[crossings_[c].arc[0]], &b = arcs_[crossings_[c].arc[1]];
    const bool b_lies_left = cross(travel(a, crossings_[c].at), travel(b, crossings_[c].at)) > 0;
    for (int side = 0; side < 2; ++side) {
      Part& out = parts_[ends_[c][1 - side].out];
      parts_[ends_[c][side].in].next = ends_[c][1 - side].out;
      out.before = crossings_[c].arc[side];
      out.right_turn = (side == 0) != b_lies_left;
    }
  }
}

// Decides whether loop_ is kept. @return false if the result is ambiguous
bool SelfIntersectionTrimmer::Trimming::judge(bool& keep) {
  double total = 0, longest[2] = {-1, -1};  // squares
  DirectedArc best[2];
  bool corners_wrong = false;
  std::size_t arcs = 0;
  const auto look = [&](geometry::Vec a, geometry::Vec b, const DirectedArc& arc) {
    const geometry::Vec way = b - a;
    const double square = dot(way, way);
    if (total < kTiny) total += std::abs(way.x) + std::abs(way.y);
    corners_wrong |= arc.site == kPivot;
    if (!(square > longest[1])) return;
    const int rank = square > longest[0] ? 0 : 1;
    if (rank == 0) {
      longest[1] = longest[0];
      best[1] = best[0];
    }
    longest[rank] = square;
    best[rank].a = a;
    best[rank].b = b;
    best[rank].site = arc.site;
  };
  for (const std::uint32_t p : loop_) {
    const Part& part = parts_[p];
    corners_wrong |= part.right_turn;
    arcs += part.last - part.first + 1;
    const DirectedArc *const first = &arcs_[part.first], *const last = &arcs_[part.last];
    look(part.from, first == last ? part.to : first->b, *first);
    for (const DirectedArc* s = first + 1; s < last; ++s) look(s->a, s->b, *s);
    if (first != last) look(last->a, part.to, *last);
  }
  keep = false;
  if (total < kTiny) return true;
  for (int i = 0; i < (corners_wrong ? 1 : 2) && longest[i] > 0.0625 * longest[0]; ++i) {
    const geometry::Vec place = middle(best[i]);
    const bool lives = best[i].site != kPivot && !(arcs <= kSmall && swept_beside(place)) && !is_swept(place);
    if (i && lives != keep) return false;
    keep = lives;
  }
  return !(keep && corners_wrong);
}

bool SelfIntersectionTrimmer::Trimming::smooth() {
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
    for (const std::uint32_t q : loop_) {  // without pivots: one edge for each arc
      const Part& part = parts_[q];
      const std::size_t first = loop.edges.size();
      const auto edges = component_->edges.begin() + arcs_[part.first].edge;
      loop.edges.insert(loop.edges.end(), edges, edges + (part.last - part.first + 1));
      WavefrontEdge& edge = loop.edges[first];
      edge.from = part.from;
      if (part.crossed && !bisector_of(sites_[std::size_t(arcs_[part.before].site)],
                                       sites_[std::size_t(edge.site)], part.from, d_, edge.start))
        return false;
    }
    loop.ends.push_back(std::uint32_t(loop.edges.size()));
  }
  return true;
}

// Loops may have passed each other and no longer cross. @return false if the result is ambiguous
bool SelfIntersectionTrimmer::Trimming::drop_swept(Component& component, Components& out) {
  const auto each_loop = [&](auto&& f) {
    std::uint32_t begin = 0;
    for (const std::uint32_t end : component.ends) f(std::exchange(begin, end), end);
  };
  loop_.clear();  // first edges of those that stay
  each_loop([&](std::uint32_t begin, std::uint32_t end) {
    if (!loop_swept(begin, end)) loop_.push_back(begin);
  });
  auto stays = loop_.begin();
  bool pivots = false;
  each_loop([&](std::uint32_t begin, std::uint32_t end) {
    if (stays == loop_.end() || *stays != begin) return;
    ++stays;
    for (std::uint32_t i = begin; i < end; ++i) pivots |= component.edges[i].pivot();
    if (loop_.size() == component.ends.size()) return;
    Component& loop = kept_.add();
    loop.edges.assign(component.edges.begin() + begin, component.edges.begin() + end);
    loop.ends.push_back(std::uint32_t(loop.edges.size()));
  });
  if (pivots) return false;
  if (loop_.size() == component.ends.size())
    out.take(component);
  else
    nest_holes_(sites_, kept_, d_, out);
  return true;
}

bool SelfIntersectionTrimmer::Trimming::trim(Component& component, double d, Components& out) {
  component_ = &component;
  d_ = d;
  kept_.clear();
  if (find_crossings()) {
    if (!smooth()) return false;
    nest_holes_(sites_, kept_, d, out);
    return true;
  }
  if (!simple_) return drop_swept(component, out);
  if (twice_area_ > 0) out.take(component);
  return true;
}

SelfIntersectionTrimmer::SelfIntersectionTrimmer() : trimming_(std::make_unique<Trimming>()) {}
SelfIntersectionTrimmer::~SelfIntersectionTrimmer() = default;

void SelfIntersectionTrimmer::begin(std::span<const Site> sites) { trimming_->begin(sites); }

bool SelfIntersectionTrimmer::operator()(Component& component, double d, Components& out) {
  if (component.ends.empty()) return true;
  return trimming_->trim(component, d, out);
}

}  // namespace firn::slice::wavefront
