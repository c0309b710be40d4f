// Edge events: an edge that shrinks to length 0 leaves the wavefront. An event changes only the edges beside
// it, so that each may be handled as soon as neither neighbour collapses earlier: the result is the same as
// in the order of distances, and no priority queue is needed.
#include <algorithm>

#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kLevel = 0.01;  // sine of the slope of a ridge below which it is level
constexpr double kMeets = 1e-3;  // units: ends no further apart meet
constexpr double kClose = 0.01;  // units: precision of the distance of an edge event

// Position of a bisector along a direction: a + b d + c sqrt(q2 d^2 + q1 d + q0).
struct Reach {
  double a = 0, b = 0, c = 0, q2 = 0, q1 = 0, q0 = 0;
  Reach(const Bisector& j, geometry::Vec along) : a(dot(j.base, along)) {
    const double ahead = dot(j.direction, along);
    switch (j.kind) {
      case Bisector::Kind::kStraight:
        b = ahead;
        return;
      case Bisector::Kind::kParabolaAhead:
      case Bisector::Kind::kParabolaBack:
        b = dot(j.normal(), along);
        c = ahead;
        q1 = 2 * j.bound;
        q0 = -j.bound * j.bound;
        return;
      case Bisector::Kind::kTwoCorners:
        c = ahead;
        q2 = 1;
        q0 = -j.bound;
        return;
    }
  }
  double root(double d) const {
    const double square = (q2 * d + q1) * d + q0;
    return square > 0 ? std::sqrt(square) : 0.0;
  }
  double slope(double d, double root) const { return root > 0 ? c * (q2 * d + 0.5 * q1) / root : 0.0; }
};

// Returns the distance at which start meets end: the extent between them falls from above 0 at `low` to
// `at_high` below it at `high`. Newton steps within the bracket, bisection where they leave it.
double edge_event(const Bisector& from, const Bisector& to, geometry::Vec along, double low, double high,
                  double at_high) {
  if (from.kind == Bisector::Kind::kStraight && to.kind == Bisector::Kind::kStraight) {  // usual
    const double a = dot(to.base, along) - dot(from.base, along),
                 b = dot(to.direction, along) - dot(from.direction, along);
    return b < 0 ? std::min(std::max(-a / b, low), high) : low;
  }
  const Reach start(from, along), end(to, along);
  const double a = end.a - start.a, b = end.b - start.b;
  if (start.c == 0 && end.c == 0) return b < 0 ? std::clamp(-a / b, low, high) : low;
  if (start.c == 0 || end.c == 0) {  // quadratic equation
    const Reach& bent = start.c == 0 ? end : start;
    const double c = start.c == 0 ? end.c : -start.c, square = c * c;
    const double two = b * b - square * bent.q2, one = a * b - 0.5 * square * bent.q1,
                 none = a * a - square * bent.q0;
    const double under = one * one - two * none;
    const double sum = -one - std::copysign(std::sqrt(std::max(under, 0.0)), one);
    for (const double d : {sum / two, none / sum})
      if (d > low && d < high && std::abs(a + b * d + c * bent.root(d)) < kMeets) return d;
  }
  double d = low, r_start = start.root(d), r_end = end.root(d);
  double value = a + b * d + end.c * r_end - start.c * r_start;
  if (value <= 0) return low;
  d = low + (high - low) * value / (value - at_high);
  for (int step = 0; step < 60; ++step) {
    r_start = start.root(d);
    r_end = end.root(d);
    value = a + b * d + end.c * r_end - start.c * r_start;
    if (value > 0)
      low = d;
    else
      high = d;
    if (std::abs(value) < kMeets || high - low <= kClose) return d;
    const double slope = b + end.slope(d, r_end) - start.slope(d, r_start);
    const double next = d - value / slope;
    d = slope < 0 && next > low && next < high ? next : 0.5 * (low + high);
  }
  return d;
}

}  // namespace

void Propagation::predict_event(std::int32_t i, double since) {
  links_[i].edge_event = kNever;
  linked_anew_.push_back(i);
  if (edges_of_loop_[i].pivot()) return;
  const WavefrontEdge &here = edges_of_loop_[i], &next = edges_of_loop_[links_[i].next];
  const geometry::Vec along = sites_[here.site].along;
  const double extent = dot(next.from - here.from, along);
  if (extent >= 0) return;
  links_[i].edge_event = edge_event(here.start, next.start, along, since, to_, extent);
}

// Returns the bisector of an edge and a fixed point, which the edge sees along its own normal.
Bisector Propagation::radial(std::int32_t i, geometry::Vec place) const {
  const Site& site = sites_[edges_of_loop_[i].site];
  const geometry::Vec away = place - site.at;
  if (!site.corner()) return {site.at + dot(away, site.along) * site.along, left_of(site.along)};
  const double l = length(away);
  return {site.at, l > 0 ? (1 / l) * away : left_of(site.along)};
}

// Returns whether a point is a local maximum of the distance: no direction leads away from all three sites
// that generate it.
bool Propagation::peak(std::int32_t a, std::int32_t b, std::int32_t c, geometry::Vec place) const {
  geometry::Vec from[3];
  for (int k = 0; k < 3; ++k) {
    const std::int32_t edge = k == 0 ? a : k == 1 ? b : c;
    if (edges_of_loop_[edge].pivot()) return false;
    const Site& site = sites_[edges_of_loop_[edge].site];
    from[k] = site.corner() ? place - site.at : left_of(site.along);
    from[k] = (1 / length(from[k])) * from[k];
  }
  const double ab = cross(from[0], from[1]), bc = cross(from[1], from[2]), ca = cross(from[2], from[0]);
  if (dot(from[0], from[1]) > 0 && dot(from[1], from[2]) > 0 && dot(from[2], from[0]) > 0) return false;
  return (ab > -kLevel && bc > -kLevel && ca > -kLevel) || (ab < kLevel && bc < kLevel && ca < kLevel);
}

void Propagation::collapse(std::int32_t i, double d) {
  const std::int32_t a = links_[i].prev, c = links_[i].next;
  const geometry::Vec place = 0.5 * (edges_of_loop_[i].start(d) + edges_of_loop_[c].start(d));
  const bool pivots = edges_of_loop_[a].pivot() || edges_of_loop_[c].pivot();
  if (d > peaks_from_ && peak(a, i, c, place)) peaks_.push_back(place);
  Bisector bisector;
  links_[i].edge_event = kNever;
  --remaining_;
  if (a != c && !pivots &&
      bisector_of(sites_[edges_of_loop_[a].site], sites_[edges_of_loop_[c].site], place, d, bisector)) {
    links_[a].next = c;
    links_[c].prev = a;
    links_[i].next = -1;
    any_collapsed_ = true;
    edges_of_loop_[c].start = bisector;
    edges_of_loop_[c].from = bisector(to_);
  } else {
    edges_of_loop_[i].site = ~std::int32_t(component_->pivots.size());
    component_->pivots.push_back(place);
    edges_of_loop_[i].start =
        edges_of_loop_[a].pivot() ? Bisector(component_->place_of(edges_of_loop_[a]), {}) : radial(a, place);
    edges_of_loop_[i].from = edges_of_loop_[i].start(to_);
    edges_of_loop_[c].start = edges_of_loop_[c].pivot() ? Bisector(place, {}) : radial(c, place);
    edges_of_loop_[c].from = edges_of_loop_[c].start(to_);
  }
  predict_event(a, d);
  predict_event(c, d);
}

// Moves all ends and lists the inverted edges.
void Propagation::list_inverted() {
  inverted_.clear();
  WavefrontEdge *const first = edges_of_loop_.data(), *const stop = first + edges_of_loop_.size();
  geometry::Vec from = first->from = first->start(to_);
  for (WavefrontEdge* edge = first; edge != stop; ++edge) {
    const geometry::Vec end = edge + 1 != stop ? edge[1].from = edge[1].start(to_) : first->from;
    if (dot(end - from, sites_[std::size_t(edge->site)].along) < 0)
      inverted_.push_back(std::int32_t(edge - first));
    from = end;
  }
}

void Propagation::link() {
  const std::size_t n = edges_of_loop_.size();
  for (std::size_t i = links_.size(); i < n; ++i)
    links_.push_back({std::int32_t(i) - 1, std::int32_t(i) + 1, kNever});
  links_[0].prev = std::int32_t(n) - 1;
  links_[n - 1].next = 0;
  linked_anew_.assign({0, std::int32_t(n) - 1});
}

void Propagation::unlink() {
  for (const std::int32_t i : linked_anew_) links_[i] = {i - 1, i + 1, kNever};
}

// Returns whether an edge collapses, and before another one.
bool Propagation::sooner(std::int32_t i, std::int32_t than) const {
  const double one = links_[i].edge_event, other = links_[than].edge_event;
  return one < other || (one == other && i < than && one < kNever);
}

// Handles the event of an edge, all events that it causes and those next to it that come earlier.
void Propagation::run_events_about(std::int32_t i) {
  pending_.assign(1, i);
  while (!pending_.empty() && remaining_ > 1) {
    std::int32_t first = pending_.back();
    if (links_[first].edge_event == kNever) {
      pending_.pop_back();
      continue;
    }
    for (;;) {
      const std::int32_t prev = links_[first].prev, next = links_[first].next;
      if (sooner(prev, first))
        first = prev;
      else if (sooner(next, first))
        first = next;
      else
        break;
    }
    const std::int32_t prev = links_[first].prev, next = links_[first].next;
    collapse(first, links_[first].edge_event);
    for (const std::int32_t beside : {prev, next})
      if (links_[beside].edge_event < kNever) pending_.push_back(beside);
  }
}

// @return false if the loop vanishes
bool Propagation::run(double from) {
  link();
  remaining_ = std::int32_t(edges_of_loop_.size());
  for (const std::int32_t i : inverted_) predict_event(i, from);
  for (const std::int32_t i : inverted_) run_events_about(i);
  return remaining_ > 1;
}

// Compacts the rest of the loop to position `to`. @return the position behind it
WavefrontEdge* Propagation::close_up(WavefrontEdge* to) const {
  WavefrontEdge *const begin = edges_of_loop_.data(), *const end = begin + edges_of_loop_.size();
  for (WavefrontEdge* edge = begin; edge != end;) {
    WavefrontEdge* stop = edge;
    if (!any_collapsed_)
      stop = end;
    else
      while (stop != end && links_[std::size_t(stop - begin)].next >= 0) ++stop;
    to = to == edge ? stop : std::copy(edge, stop, to);
    edge = stop == end ? end : stop + 1;
  }
  return to;
}

void Propagation::operator()(std::span<const Site> sites, Component& component, double from, double to) {
  sites_ = sites;
  component_ = &component;
  to_ = to;
  // In place: the rest of a loop is no longer than the loop, and in its order.
  WavefrontEdge *const edges = component.edges.data(), *written = edges;
  std::size_t begin = 0, loops = 0;
  for (const std::uint32_t end : component.ends) {
    edges_of_loop_ = std::span(edges + begin, end - begin);
    begin = end;
    any_collapsed_ = false;
    const std::size_t pivots = component.pivots.size();
    list_inverted();
    const bool lives = inverted_.empty() || run(from);
    if (lives) {
      written = close_up(written);
      component.ends[loops++] = std::uint32_t(written - edges);
    } else {
      component.pivots.resize(pivots);
    }
    if (!inverted_.empty()) unlink();
  }
  component.edges.resize(std::size_t(written - edges));
  component.ends.resize(loops);
}

}  // namespace firn::slice::wavefront
