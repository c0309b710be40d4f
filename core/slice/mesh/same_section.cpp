#include "core/slice/mesh/same_section.h"

#include <cmath>
#include <span>

#include "core/geometry/vec.h"

namespace firn::slice {
namespace {

constexpr double kStraight = 1.0;  // unit

// The directions from a point that pass others by no more than kStraight [Williams 1978].
class Cone {
 public:
  void clear() { narrowed_ = false; }
  void narrow(geometry::Vec to) {
    const double square = dot(to, to);
    if (square <= kStraight * kStraight) return;
    const geometry::Vec ahead = std::sqrt(square - kStraight * kStraight) * to,
                        aside = kStraight * left_of(to);
    const geometry::Vec right = ahead - aside, left = ahead + aside;
    if (!narrowed_ || cross(right_, right) > 0) right_ = right;
    if (!narrowed_ || cross(left, left_) > 0) left_ = left;
    narrowed_ = true;
  }
  bool holds(geometry::Vec direction) const {
    return !narrowed_ || (cross(right_, direction) >= 0 && cross(direction, left_) >= 0);
  }

 private:
  geometry::Vec right_, left_;
  bool narrowed_ = false;
};

class Corners {
 public:
  explicit Corners(std::span<const geometry::Point> ring) : ring_(ring) {}
  /// The next corner; nullptr at the end. The first point is one.
  const geometry::Point* next() {
    if (behind_ == ring_.size()) return nullptr;
    if (behind_ > 0) {
      cone_.clear();
      while (left_out(behind_))
        if (++behind_ == ring_.size()) return nullptr;
    }
    last_ = behind_;
    return &ring_[behind_++];
  }

 private:
  geometry::Vec from_last(std::size_t n) const { return to_vec(ring_[n]) - to_vec(ring_[last_]); }
  // Returns true if this point, like those since the last corner, is passed by on the way to the one behind
  // it.
  bool left_out(std::size_t n) {
    const geometry::Vec here = from_last(n), there = from_last(n + 1 < ring_.size() ? n + 1 : 0);
    cone_.narrow(here);
    return cone_.holds(there) && dot(here, there) >= 0 && dot(there - here, there) >= 0;
  }

  std::span<const geometry::Point> ring_;
  Cone cone_;
  std::size_t last_ = 0, behind_ = 0;
};

}  // namespace

bool same_section(const geometry::Rings& a, const geometry::Rings& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t r = 0; r < a.size(); ++r) {
    Corners of_a(a[r]), of_b(b[r]);
    for (;;) {
      const geometry::Point *const p = of_a.next(), *const q = of_b.next();
      if (!p || !q) {
        if (p || q) return false;
        break;
      }
      if (*p != *q) return false;
    }
  }
  return true;
}

}  // namespace firn::slice
