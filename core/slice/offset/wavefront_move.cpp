// Local deaths: a piece that shrinks to nothing leaves the front. Deaths change what follows only beside
// them, so that each may come as soon as neither neighbour dies before: what follows is the same as in the
// order of distances, and no queue is needed.
#include <algorithm>

#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kLevel = 0.01;  // sine of the rise of a ridge that is level
constexpr double kMeets = 1e-3;  // units: ends no further apart have met
constexpr double kClose = 0.01;  // units: distances of death are searched to this

// How far a junction lies along a direction: a + b d + c sqrt(q2 d^2 + q1 d + q0).
struct Reach {
  double a = 0, b = 0, c = 0, q2 = 0, q1 = 0, q0 = 0;
  Reach(const Junction& j, Vec along) : a(dot(j.base, along)) {
    const double ahead = dot(j.direction, along);
    switch (j.kind) {
      case Junction::Kind::kStraight:
        b = ahead;
        return;
      case Junction::Kind::kParabolaAhead:
      case Junction::Kind::kParabolaBack:
        b = dot(j.normal(), along), c = ahead;
        q1 = 2 * j.bound, q0 = -j.bound * j.bound;
        return;
      case Junction::Kind::kTwoCorners:
        c = ahead;
        q2 = 1, q0 = -j.bound;
        return;
    }
  }
  double root(double d) const {
    const double square = (q2 * d + q1) * d + q0;
    return square > 0 ? std::sqrt(square) : 0.0;
  }
  double slope(double d, double root) const { return root > 0 ? c * (q2 * d + 0.5 * q1) / root : 0.0; }
};

// Where start meets end: the extent between them falls from above 0 at `low` to `at_high` below it at `high`.
// Newton's steps within the bracket, halves where they leave it.
double death(const Junction& from, const Junction& to, Vec along, double low, double high, double at_high) {
  if (from.kind == Junction::Kind::kStraight && to.kind == Junction::Kind::kStraight) {  // mostly
    const double a = dot(to.base, along) - dot(from.base, along),
                 b = dot(to.direction, along) - dot(from.direction, along);
    return b < 0 ? std::min(std::max(-a / b, low), high) : low;
  }
  const Reach start(from, along), end(to, along);
  const double a = end.a - start.a, b = end.b - start.b;
  if (start.c == 0 && end.c == 0) return b < 0 ? std::clamp(-a / b, low, high) : low;
  if (start.c == 0 || end.c == 0) {  // a square's root
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
    r_start = start.root(d), r_end = end.root(d);
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

void Mover::expect_death(std::int32_t i, double since) {
  links_[i].death = kNever;
  linked_anew_.push_back(i);
  if (pieces_[i].pivot()) return;
  const Piece &here = pieces_[i], &next = pieces_[links_[i].next];
  const Vec along = sources_[here.source].along;
  const double extent = dot(next.from - here.from, along);
  if (extent >= 0) return;
  links_[i].death = death(here.start, next.start, along, since, to_, extent);
}

// Junction of a piece with a fixed place, which it sees along its own normal.
Junction Mover::radial(std::int32_t i, Vec place) const {
  const Source& source = sources_[pieces_[i].source];
  const Vec away = place - source.at;
  if (!source.corner()) return {source.at + dot(away, source.along) * source.along, left_of(source.along)};
  const double l = length(away);
  return {source.at, l > 0 ? (1 / l) * away : left_of(source.along)};
}

// Do the ways to a place from what three pieces come from leave no direction that leads away from all of it?
bool Mover::peak(std::int32_t a, std::int32_t b, std::int32_t c, Vec place) const {
  Vec from[3];
  for (int k = 0; k < 3; ++k) {
    const std::int32_t piece = k == 0 ? a : k == 1 ? b : c;
    if (pieces_[piece].pivot()) return false;
    const Source& source = sources_[pieces_[piece].source];
    from[k] = source.corner() ? place - source.at : left_of(source.along);
    from[k] = (1 / length(from[k])) * from[k];
  }
  const double ab = cross(from[0], from[1]), bc = cross(from[1], from[2]), ca = cross(from[2], from[0]);
  if (dot(from[0], from[1]) > 0 && dot(from[1], from[2]) > 0 && dot(from[2], from[0]) > 0) return false;
  return (ab > -kLevel && bc > -kLevel && ca > -kLevel) || (ab < kLevel && bc < kLevel && ca < kLevel);
}

void Mover::die(std::int32_t i, double d) {
  const std::int32_t a = links_[i].prev, c = links_[i].next;
  const Vec place = 0.5 * (pieces_[i].start(d) + pieces_[c].start(d));
  const bool pivots = pieces_[a].pivot() || pieces_[c].pivot();
  if (d > peaks_from_ && peak(a, i, c, place)) peaks_.push_back(place);
  Junction junction;
  links_[i].death = kNever;
  --alive_;
  if (a != c && !pivots &&
      meet(sources_[pieces_[a].source], sources_[pieces_[c].source], place, d, junction)) {
    links_[a].next = c;
    links_[c].prev = a;
    links_[i].next = -1;
    any_dead_ = true;
    pieces_[c].start = junction;
    pieces_[c].from = junction(to_);
  } else {
    pieces_[i].source = ~std::int32_t(component_->pivots.size());
    component_->pivots.push_back(place);
    pieces_[i].start = pieces_[a].pivot() ? Junction(component_->place_of(pieces_[a]), {}) : radial(a, place);
    pieces_[i].from = pieces_[i].start(to_);
    pieces_[c].start = pieces_[c].pivot() ? Junction(place, {}) : radial(c, place);
    pieces_[c].from = pieces_[c].start(to_);
  }
  expect_death(a, d);
  expect_death(c, d);
}

// Moves all ends; lists the pieces whose ends then lie the wrong way round.
void Mover::list_inverted() {
  inverted_.clear();
  Piece *const first = pieces_.data(), *const stop = first + pieces_.size();
  Vec from = first->from = first->start(to_);
  for (Piece* piece = first; piece != stop; ++piece) {
    const Vec end = piece + 1 != stop ? piece[1].from = piece[1].start(to_) : first->from;
    if (dot(end - from, sources_[std::size_t(piece->source)].along) < 0)
      inverted_.push_back(std::int32_t(piece - first));
    from = end;
  }
}

void Mover::link() {
  const std::size_t n = pieces_.size();
  for (std::size_t i = links_.size(); i < n; ++i)
    links_.push_back({std::int32_t(i) - 1, std::int32_t(i) + 1, kNever});
  links_[0].prev = std::int32_t(n) - 1;
  links_[n - 1].next = 0;
  linked_anew_.assign({0, std::int32_t(n) - 1});
}

void Mover::unlink() {
  for (const std::int32_t i : linked_anew_) links_[i] = {i - 1, i + 1, kNever};
}

// Does a piece die, and before another one?
bool Mover::sooner(std::int32_t i, std::int32_t than) const {
  const double one = links_[i].death, other = links_[than].death;
  return one < other || (one == other && i < than && one < kNever);
}

// All deaths that follow from the one of a piece, and those about it that come before.
void Mover::die_about(std::int32_t i) {
  dying_.assign(1, i);
  while (!dying_.empty() && alive_ > 1) {
    std::int32_t first = dying_.back();
    if (links_[first].death == kNever) {
      dying_.pop_back();
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
    die(first, links_[first].death);
    for (const std::int32_t beside : {prev, next})
      if (links_[beside].death < kNever) dying_.push_back(beside);
  }
}

// @return false if nothing of the loop is left
bool Mover::run(double from) {
  link();
  alive_ = std::int32_t(pieces_.size());
  for (const std::int32_t i : inverted_) expect_death(i, from);
  for (const std::int32_t i : inverted_) die_about(i);
  return alive_ > 1;
}

// Closes up what is left of the loop, from place `to` on. @return the place behind it
Piece* Mover::close_up(Piece* to) const {
  Piece *const begin = pieces_.data(), *const end = begin + pieces_.size();
  for (Piece* piece = begin; piece != end;) {
    Piece* stop = piece;
    if (!any_dead_)
      stop = end;
    else
      while (stop != end && links_[std::size_t(stop - begin)].next >= 0) ++stop;
    to = to == piece ? stop : std::copy(piece, stop, to);
    piece = stop == end ? end : stop + 1;
  }
  return to;
}

void Mover::operator()(std::span<const Source> sources, Component& component, double from, double to) {
  sources_ = sources;
  component_ = &component;
  to_ = to;
  // In place: what is left of a loop is no longer than the loop, and in its order.
  Piece *const pieces = component.pieces.data(), *written = pieces;
  std::size_t begin = 0, loops = 0;
  for (const std::uint32_t end : component.ends) {
    pieces_ = std::span(pieces + begin, end - begin);
    begin = end;
    any_dead_ = false;
    const std::size_t pivots = component.pivots.size();
    list_inverted();
    const bool lives = inverted_.empty() || run(from);
    if (lives) {
      written = close_up(written);
      component.ends[loops++] = std::uint32_t(written - pieces);
    } else {
      component.pivots.resize(pivots);
    }
    if (!inverted_.empty()) unlink();
  }
  component.pieces.resize(std::size_t(written - pieces));
  component.ends.resize(loops);
}

}  // namespace firn::slice::wavefront
