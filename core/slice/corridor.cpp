#include "core/slice/corridor.h"

#include <algorithm>
#include <span>

namespace firn::slice {
namespace {

constexpr double kUpright = 1e6;     // slope of a line that nothing bounds yet
constexpr double kWhole = 0.95;      // of a gate
constexpr double kSharpest = 0.7;    // cosine of a turn: a gate across the one way is none across the other
constexpr double kStraightOn = 0.95; // the same: a gate across the one way will do

// Units: a place no further along than this is beside the one before; it may then lie a little nearer to a line turned furthest.
constexpr double kBeside = 1e-3, kLittle = 0.5;

Vec turned_over(Vec v) { return {v.x, -v.y}; }

}  // namespace

Vec Corridor::Window::crossing(const Line& by) const {
  const double sine = cross(line.along, by.along);
  const double along = sine != 0 ? cross(by.at - line.at, by.along) / sine : last;
  return line.at + std::min(std::max(along, first), last) * line.along;
}

void Corridor::reserve(std::size_t gates) {
  if (ends_.size() < 2 * (gates + 1)) ends_.resize(2 * (gates + 1));
  walls_[0].ends = ends_.data();
  walls_[1].ends = ends_.data() + gates + 1;
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
  behind = bound = ends + 1;
  support = ends;
  contact = nullptr;
  aim(end, kUpright);
}

// The end of a gate bounds the line turned furthest to its side: it now passes there, and touches the other wall before.
inline void Corridor::Wall::touch(Wall& other, Vec end) {
  const Vec to = turned_over(end);
  Vec way = to - *other.support;
  for (; other.support + 1 < other.behind; ++other.support) {
    const Vec next = to - other.support[1];
    if (cross(way, next) < 0) break;
    way = next;
  }
  other.bound = std::max(other.bound, other.support + 1);
  aim(end, -way.y / way.x);
}

// What bounds no line to come goes.
inline void Corridor::Wall::add(Vec end, bool touched) {
  Vec* const least = touched ? support + 1 : bound;
  while (behind > least && cross(behind[-1] - behind[-2], end - behind[-1]) <= 0) --behind;
  *behind++ = end;
  if (touched) contact = behind - 1, bound = behind;
}

Corridor::Turn Corridor::take(std::span<const Vec> places, std::size_t& i, Width width) {
  Wall left = walls_[0], right = walls_[1];
  const Vec origin = origin_, along = along_;
  double reach = reach_, last_y = last_place_;
  Turn turn = Turn::kNone;
  for (; i < places.size(); ++i) {
    const Vec off = places[i] - origin;
    const double x = dot(along, off), y = cross(along, off);
    const Vec left_end{x, y + width.left}, right_end{x, width.right - y};
    const double left_line = left.at(x), right_line = right.at(x);
    if (x < reach) turn = Turn::kBack;
    else if (-right_end.y > left_line) turn = Turn::kLeft;
    else if (-left_end.y > right_line) turn = Turn::kRight;
    if (turn != Turn::kNone) break;
    const bool left_nearer = left_end.y < left_line, right_nearer = right_end.y < right_line;
    if (x - reach < kBeside) {
      if (left_end.y > left_line - kLittle && right_end.y > right_line - kLittle) continue;
      turn = Turn::kBack;
      break;
    }
    if (left_nearer) left.touch(right, left_end);
    if (right_nearer) right.touch(left, right_end);
    left.add(left_end, left_nearer);
    right.add(right_end, right_nearer);
    reach = x, last_y = y;
    last_[0] = left_end.y, last_[1] = right_end.y;
  }
  walls_[0] = left, walls_[1] = right;
  reach_ = reach, last_place_ = last_y;
  return turn;
}

bool Corridor::last_is_whole() const {
  return walls_[0].at(reach_) + walls_[1].at(reach_) >= kWhole * (last_[0] + last_[1]);
}

Corridor::End Corridor::end() const {
  const Wall &left = walls_[0], &right = walls_[1];
  const double below = right.at(reach_), width = left.at(reach_) + below;
  const double share = last_is_whole() && width > 0 ? std::clamp((last_place_ + below) / width, 0.0, 1.0) : 0.5;
  const double slope = share * left.slope - (1 - share) * right.slope, offset = share * left.offset - (1 - share) * right.offset;
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
    // The ends' gates stand across the way that led there. Where they reach beyond the next gate, all that is behind the
    // last one keeps to the line that led there.
    if (frame(missed).x < reach) {
      window.first = reach_;
      near.ends[0] = last;
      near.behind = near.ends + 1;
    }
  }
  // Lines through the exit, the far wall's only end: past the near wall's ends behind it and past those ahead of it.
  const Vec from = far.ends[0];
  reach_ = from.x;
  near.support = near.ends, near.bound = near.ends + 1, near.contact = nullptr;
  near.aim(turned_over(from), kUpright);
  for (Vec* end = near.ends; end != near.behind; ++end) {
    const Vec off = from - turned_over(*end);
    if (off.x > 0 && off.y < far.slope * off.x) {
      far.aim(from, off.y / off.x);
      far.contact = far.ends;
      near.support = end, near.bound = end + 1;
    } else if (off.x < 0 && off.y < near.slope * -off.x) {
      near.aim(*end, off.y / -off.x);
      near.contact = end, near.bound = end + 1;
    }
    reach_ = std::max(reach_, end->x);
  }
  return true;
}

}  // namespace firn::slice
