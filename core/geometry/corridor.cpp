#include "core/geometry/corridor.h"

#include <algorithm>
#include <span>

#include "core/geometry/lanes.h"

namespace firn::slice {
namespace {

constexpr double kUpright = 1e6;      // slope of a line that nothing bounds yet
constexpr double kWhole = 0.95;       // of a gate
constexpr double kSharpest = 0.7;     // cosine of a turn: a gate across the one way is none across the other
constexpr double kStraightOn = 0.95;  // the same: a gate across the one way will do

// Units: a place no further along than this is beside the one before; it may then lie a little nearer to a
// line turned furthest.
constexpr double kBeside = 1e-3, kLittle = 0.5;

constexpr unsigned kLooked = 3;  // ends of a wall that are looked at with every gate, needed or not

Vec turned_over(Vec v) { return {v.x, -v.y}; }

// Both sides at once: the left one's, the right one's.
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

Vec Corridor::Window::crossing(const Line& by) const {
  const double sine = cross(line.along, by.along);
  const double along = sine != 0 ? cross(by.at - line.at, by.along) / sine : last;
  return line.at + std::min(std::max(along, first), last) * line.along;
}

void Corridor::reserve(std::size_t gates) {
  // With room for what is looked at, though never heeded: kLooked more before them and one more behind.
  const std::size_t each = kLooked + gates + 2;
  if (ends_.size() < 2 * each) ends_.resize(2 * each);
  walls_[0].ends = ends_.data() + kLooked;
  walls_[1].ends = walls_[0].ends + each;
}

void Corridor::begin(Vec at, Vec toward) {
  const Vec way = toward - at;
  const double l = length(way);
  origin_ = at;
  along_ = l > 0 ? (1 / l) * way : Vec{1, 0};
  reach_ = 0;
  for (Wall& wall : walls_) wall.begin({});
}

void Corridor::Wall::begin(Vec end) {
  ends[0] = end;
  behind = ends + 1;
  support = ends;
  contact = nullptr;
  aim(end, kUpright);
}

// The line turned furthest to the other side comes to pass the end of a gate there: it now touches this wall
// before.
inline void Corridor::Wall::move_support(Vec end) {
  const Vec to = turned_over(end);
  for (Vec way = to - *support; support + 1 < behind; ++support) {
    const Vec next = to - support[1];
    if (cross(way, next) < 0) break;
    way = next;
  }
}

// What bounds no line to come goes: at least as many of the last kLooked ends as are hidden, if there are so
// many that may go.
inline void Corridor::Wall::add(Vec end, bool touched, unsigned hidden) {
  Vec* const least = (touched || !contact ? support : std::max(support, contact)) + 1;
  behind = std::max(behind - hidden, least);
  if (hidden == kLooked)
    while (behind > least && cross(behind[-1] - behind[-2], end - behind[-1]) <= 0) --behind;
  contact = touched ? behind : contact;
  *behind++ = end;
}

// Hardly anything here can be foretold from gate to gate, so that branches are dear: both sides are dealt
// with side by side, and what is seldom needed has the only ones.
Corridor::Turn Corridor::take(std::span<const Vec> places, std::size_t& i, Width width) {
  Wall left = walls_[0], right = walls_[1];
  const Pair origin{origin_.x, origin_.y}, along{along_.x, along_.x}, across{along_.y, -along_.y};
  const Pair near{width.left, width.right}, far{width.right, width.left};
  Pair slope{left.slope, right.slope}, offset{left.offset, right.offset};
  Places support(*right.support, *left.support);  // of the line turned furthest to the left, to the right
  Places b1(left.behind[-1], right.behind[-1]);   // the last ends; b2 is what comes before them
  double reach = reach_, last_place = last_place_;
  Turn turn = Turn::kNone;
  std::size_t n = i;
  for (; n < places.size(); ++n) {
    const Pair off = Pair{places[n].x, places[n].y} - origin;
    const Pair at = along * off + across * swapped(off);  // frame(places[n])
    const Pair x = __builtin_shufflevector(at, at, 0, 0), y = __builtin_shufflevector(at, -at, 1, 3);
    const Pair end = near + y, line = offset + slope * x;
    const int missed = lanes_of(y - far > line);
    if (at[0] - reach < kBeside || missed) {
      if (at[0] < reach)
        turn = Turn::kBack;
      else if (missed)
        turn = missed & 1 ? Turn::kLeft : Turn::kRight;
      else if (lanes_of(end > line - kLittle) == 3)
        continue;
      else
        turn = Turn::kBack;
      break;
    }
    // The end of a gate that is nearer than the line turned furthest to its side bounds that: it now passes
    // there.
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
    const auto before = [&](int k) { return Places(left.behind[-k], right.behind[-k]); };
    const Places ends(x, end), b2 = before(2), b3 = before(3), b4 = before(4);
    const unsigned one = lanes_of(cross(b1 - b2, ends - b1) <= 0.0),
                   two = one & lanes_of(cross(b2 - b3, ends - b2) <= 0.0);
    const unsigned three = two & lanes_of(cross(b3 - b4, ends - b3) <= 0.0);
    left.add({at[0], end[0]}, touched & 1, (one & 1) + (two & 1) + (three & 1));
    right.add({at[0], end[1]}, touched >> 1, (one >> 1) + (two >> 1) + (three >> 1));
    b1 = ends;
    reach = at[0], last_place = at[1];
  }
  i = n;
  left.slope = slope[0], right.slope = slope[1];
  left.offset = offset[0], right.offset = offset[1];
  walls_[0] = left, walls_[1] = right;
  if (reach > reach_) last_[0] = b1.y[0], last_[1] = b1.y[1];
  reach_ = reach, last_place_ = last_place;
  return turn;
}

bool Corridor::last_is_whole() const {
  return walls_[0].at(reach_) + walls_[1].at(reach_) >= kWhole * (last_[0] + last_[1]);
}

Corridor::End Corridor::end() const {
  const Wall &left = walls_[0], &right = walls_[1];
  const double below = right.at(reach_), width = left.at(reach_) + below;
  const double share =
      last_is_whole() && width > 0 ? std::clamp((last_place_ + below) / width, 0.0, 1.0) : 0.5;
  const double slope = share * left.slope - (1 - share) * right.slope,
               offset = share * left.offset - (1 - share) * right.offset;
  return {{place({0, offset}), along_ + slope * left_of(along_)}, place({reach_, offset + slope * reach_})};
}

bool Corridor::window(Turn turn, Vec missed, Width width, Window& window) const {
  if (turn != Turn::kLeft && turn != Turn::kRight) return false;
  const int side = turn == Turn::kLeft ? 0 : 1;
  const Wall& wall = walls_[side];
  if (!wall.contact) return false;
  // In the frame, seen from the side: it leaves between the far ends of the last gate and of the one missed.
  const Vec gate = frame(missed);
  const double floor = -last_[1 - side], next_floor = side == 0 ? gate.y - width.right : -gate.y - width.left;
  const double over = wall.at(reach_) - floor, under = next_floor - wall.at(gate.x);
  const double share = over + under > 0 ? std::clamp(over / (over + under), 0.0, 1.0) : 0.0;
  const double left = side == 0 ? 1 : -1;
  window.line = {place({0, left * wall.offset}), along_ + (left * wall.slope) * left_of(along_)};
  window.first = wall.contact->x;
  window.last = reach_ + share * (gate.x - reach_);
  return true;
}

bool Corridor::pass_on(Turn turn, Window& window, Vec toward, Vec missed) {
  const Vec exit = window.far_end(), way = toward - exit;
  const double l = length(way), cosine = dot(way, along_);
  if (l == 0 || cosine < kSharpest * l) return false;
  const int side = turn == Turn::kLeft ? 0 : 1;
  Wall &near = walls_[side], &far = walls_[1 - side];
  const double left = side == 0 ? 1 : -1;
  const Vec at = frame(exit);
  near.behind = std::copy(near.contact, near.behind, near.ends);
  far.begin({at.x, -left * at.y});
  if (cosine < kStraightOn * l) {
    // Into the frame of the way to come.
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
    // The ends' gates stand across the way that led there. Where they reach beyond the next gate, all that is
    // behind the last one keeps to the line that led there.
    if (frame(missed).x < reach) {
      window.first = reach_;
      near.ends[0] = last;
      near.behind = near.ends + 1;
    }
  }
  // Lines through the exit, the far wall's only end: past the near wall's ends behind it and past those ahead
  // of it.
  const Vec from = far.ends[0];
  reach_ = from.x;
  near.support = near.ends, near.contact = nullptr;
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

}  // namespace firn::slice
