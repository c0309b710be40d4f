#include "core/geometry/tolerance_tube.h"

#include <algorithm>
#include <span>

#include "core/geometry/lanes.h"

namespace firn::geometry {
namespace {

constexpr double kUpright = 1e6;  // slope of a line without a bound
// Share of a cross-section between the supporting lines from which all of it can be reached.
constexpr double kReachableShare = 0.95;
// Cosine of the turn beyond which a cross-section cannot be used for the next edge, and of that below which
// it can be used unchanged.
constexpr double kMinCosine = 0.7, kUnchangedCosine = 0.95;
// A vertex that lies at most so far ahead of the one before [units] is beside it and adds no cross-section,
// if its ends are nearer than the supporting lines by at most kEndTolerance, which is below the grid's step.
constexpr double kMinAdvance = 1e-3, kEndTolerance = 0.5;
// Last ends of a hull that are examined with every cross-section. More are seldom hidden at once; a loop
// removes them then.
constexpr unsigned kExaminedEnds = 3;

Vec turned_over(Vec v) { return {v.x, -v.y}; }

// Both sides at once: left, right.
using Pair = Lanes2;

Pair swapped(Pair p) { return __builtin_shufflevector(p, p, 1, 0); }

struct Places {
  Places(Pair x, Pair y) : x(x), y(y) {}
  Places(const Vec& left, const Vec& right) : x{left.x, right.x}, y{left.y, right.y} {}
  Pair x, y;
};
Places operator-(const Places& a, const Places& b) { return {a.x - b.x, a.y - b.y}; }
Pair cross(const Places& a, const Places& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

Vec ToleranceTube::Window::crossing(const Line& by) const {
  const double sine = cross(line.along, by.along);
  const double along = sine != 0 ? cross(by.at - line.at, by.along) / sine : last;
  return line.at + std::min(std::max(along, first), last) * line.along;
}

void ToleranceTube::reserve(std::size_t sections) {
  // Includes room for ends that are examined but never used: kExaminedEnds before them and one behind.
  const std::size_t each = kExaminedEnds + sections + 2;
  if (ends_.size() < 2 * each) ends_.resize(2 * each);
  hulls_[0].ends = ends_.data() + kExaminedEnds;
  hulls_[1].ends = hulls_[0].ends + each;
}

void ToleranceTube::begin(Vec at, Vec toward) {
  const Vec way = toward - at;
  const double l = length(way);
  origin_ = at;
  along_ = l > 0 ? (1 / l) * way : Vec{1, 0};
  reach_ = 0;
  for (Hull& hull : hulls_) hull.begin({});
}

void ToleranceTube::Hull::begin(Vec end) {
  ends[0] = end;
  behind = ends + 1;
  support = ends;
  contact = nullptr;
  aim(end, kUpright);
}

// The supporting line of the other side now passes through the end of a cross-section there, and touches this
// hull earlier.
inline void ToleranceTube::Hull::move_support(Vec end) {
  const Vec to = turned_over(end);
  for (Vec way = to - *support; support + 1 < behind; ++support) {
    const Vec next = to - support[1];
    if (cross(way, next) < 0) break;
    way = next;
  }
}

// Removes ends that bound no later line: at least as many of the last kExaminedEnds ends as are hidden, if so
// many may be removed.
inline void ToleranceTube::Hull::add(Vec end, bool touched, unsigned hidden) {
  Vec* const least = (touched || !contact ? support : std::max(support, contact)) + 1;
  behind = std::max(behind - hidden, least);
  if (hidden == kExaminedEnds)
    while (behind > least && cross(behind[-1] - behind[-2], end - behind[-1]) <= 0) --behind;
  contact = touched ? behind : contact;
  *behind++ = end;
}

// Branches are hardly predictable from one cross-section to the next: both sides are computed together, and
// only rare cases branch.
ToleranceTube::Turn ToleranceTube::take(std::span<const Vec> places, std::size_t& i, Width width) {
  Hull left = hulls_[0], right = hulls_[1];
  const Pair origin{origin_.x, origin_.y}, along{along_.x, along_.x}, across{along_.y, -along_.y};
  const Pair near{width.left, width.right}, far{width.right, width.left};
  Pair slope{left.slope, right.slope}, offset{left.offset, right.offset};
  Places support(*right.support, *left.support);        // of the left and the right supporting line
  Places last_ends(left.behind[-1], right.behind[-1]);  // of the hulls
  double reach = reach_, last_place = last_place_;
  Turn turn = Turn::kNone;
  std::size_t n = i;
  for (; n < places.size(); ++n) {
    const Pair off = Pair{places[n].x, places[n].y} - origin;
    const Pair at = along * off + across * swapped(off);  // frame(places[n])
    const Pair x = __builtin_shufflevector(at, at, 0, 0), y = __builtin_shufflevector(at, -at, 1, 3);
    const Pair end = near + y, line = offset + slope * x;
    const int missed = lanes_of(y - far > line);
    if (at[0] - reach < kMinAdvance || missed) {
      if (at[0] < reach)
        turn = Turn::kBack;
      else if (missed)
        turn = missed & 1 ? Turn::kLeft : Turn::kRight;
      else if (lanes_of(end > line - kEndTolerance) == 3)
        continue;
      else
        turn = Turn::kBack;
      break;
    }
    // An end of a cross-section that is nearer than the supporting line of its side becomes its contact.
    const Held2 nearer = end < line;
    const int touched = lanes_of(nearer);
    const Places to(x, -end), next = to - Places(right.support[1], left.support[1]);
    Places way = to - support;
    if (const int moved = touched & ~lanes_of(cross(way, next) < 0)) {
      if (moved & 1) right.move_support({at[0], end[0]});
      if (moved & 2) left.move_support({at[0], end[1]});
      support = Places(*right.support, *left.support);
      way = to - support;
    }
    const Pair to_slope = -way.y / way.x, to_offset = end - to_slope * x;
    slope = nearer ? to_slope : slope;
    offset = nearer ? to_offset : offset;
    // A hull's last end is hidden if the hull turns inward there on its way to the new end; one bit a side.
    const auto from_last = [&](int k) { return Places(left.behind[-k], right.behind[-k]); };
    const Places ends(x, end), second = from_last(2), third = from_last(3), fourth = from_last(4);
    const unsigned hides_1 = lanes_of(cross(last_ends - second, ends - last_ends) <= 0.0),
                   hides_2 = hides_1 & lanes_of(cross(second - third, ends - second) <= 0.0),
                   hides_3 = hides_2 & lanes_of(cross(third - fourth, ends - third) <= 0.0);
    left.add({at[0], end[0]}, touched & 1, (hides_1 & 1) + (hides_2 & 1) + (hides_3 & 1));
    right.add({at[0], end[1]}, touched >> 1, (hides_1 >> 1) + (hides_2 >> 1) + (hides_3 >> 1));
    last_ends = ends;
    reach = at[0];
    last_place = at[1];
  }
  i = n;
  left.slope = slope[0];
  right.slope = slope[1];
  left.offset = offset[0];
  right.offset = offset[1];
  hulls_[0] = left;
  hulls_[1] = right;
  if (reach > reach_) {
    last_[0] = last_ends.y[0];
    last_[1] = last_ends.y[1];
  }
  reach_ = reach;
  last_place_ = last_place;
  return turn;
}

bool ToleranceTube::spans_last_section() const {
  return hulls_[0].at(reach_) + hulls_[1].at(reach_) >= kReachableShare * (last_[0] + last_[1]);
}

ToleranceTube::End ToleranceTube::end() const {
  const Hull &left = hulls_[0], &right = hulls_[1];
  const double below = right.at(reach_), width = left.at(reach_) + below;
  const double share =
      spans_last_section() && width > 0 ? std::clamp((last_place_ + below) / width, 0.0, 1.0) : 0.5;
  const double slope = share * left.slope - (1 - share) * right.slope,
               offset = share * left.offset - (1 - share) * right.offset;
  return {{place({0, offset}), along_ + slope * left_of(along_)}, place({reach_, offset + slope * reach_})};
}

bool ToleranceTube::window(Turn turn, Vec missed, Width width, Window& window) const {
  if (turn != Turn::kLeft && turn != Turn::kRight) return false;
  const int side = turn == Turn::kLeft ? 0 : 1;
  const Hull& hull = hulls_[side];
  if (!hull.contact) return false;
  // In the frame of the side: the line leaves between the far ends of the last cross-section and of the
  // missed one.
  const Vec section = frame(missed);
  const double floor = -last_[1 - side],
               next_floor = side == 0 ? section.y - width.right : -section.y - width.left;
  const double over = hull.at(reach_) - floor, under = next_floor - hull.at(section.x);
  const double share = over + under > 0 ? std::clamp(over / (over + under), 0.0, 1.0) : 0.0;
  const double left = side == 0 ? 1 : -1;
  window.line = {place({0, left * hull.offset}), along_ + (left * hull.slope) * left_of(along_)};
  window.first = hull.contact->x;
  window.last = reach_ + share * (section.x - reach_);
  return true;
}

bool ToleranceTube::pass_on(Turn turn, Window& window, Vec toward, Vec missed) {
  const Vec exit = window.far_end(), way = toward - exit;
  const double l = length(way), cosine = dot(way, along_);
  if (l == 0 || cosine < kMinCosine * l) return false;
  const int side = turn == Turn::kLeft ? 0 : 1;
  Hull &near = hulls_[side], &far = hulls_[1 - side];
  const double left = side == 0 ? 1 : -1;
  const Vec at = frame(exit);
  near.behind = std::copy(near.contact, near.behind, near.ends);
  far.begin({at.x, -left * at.y});
  if (cosine < kUnchangedCosine * l) {
    // Transforms the hull into the frame of the next edge.
    const Vec turned{dot(way, along_) / l, cross(along_, way) / l};
    const auto in_frame = [&](Vec end) {
      const Vec off{end.x - at.x, left * end.y - at.y};
      return Vec{dot(turned, off), left * cross(turned, off)};
    };
    const Vec last = in_frame({reach_, near.at(reach_)});
    double reach = 0;
    for (Vec& end : std::span(near.ends, near.behind)) {
      end = in_frame(end);
      reach = std::max(reach, end.x);
    }
    far.begin({});
    origin_ = exit;
    along_ = (1 / l) * way;
    // The cross-sections of these ends are perpendicular to the previous direction. Where they reach beyond
    // the next cross-section, all points behind the last one remain on the line that led there.
    if (frame(missed).x < reach) {
      window.first = reach_;
      near.ends[0] = last;
      near.behind = near.ends + 1;
    }
  }
  // Lines through the exit, which is the only end of the far hull: past the ends of the near hull behind it
  // and past those ahead of it.
  const Vec from = far.ends[0];
  reach_ = from.x;
  near.support = near.ends;
  near.contact = nullptr;
  near.aim(turned_over(from), kUpright);
  for (Vec* end = near.ends; end != near.behind; ++end) {
    const Vec off = from - turned_over(*end);
    if (off.x > 0 && off.y < far.slope * off.x) {
      far.aim(from, off.y / off.x);
      far.contact = far.ends;
      near.support = end;
    } else if (off.x < 0 && off.y < near.slope * -off.x) {
      near.aim(*end, off.y / -off.x);
      near.contact = end;
    }
    reach_ = std::max(reach_, end->x);
  }
  return true;
}

}  // namespace firn::geometry
