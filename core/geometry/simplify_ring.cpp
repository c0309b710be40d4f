#include "core/geometry/simplify_ring.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/ring_writer.h"

namespace firn::geometry {
namespace {

// An edge that grows from an anchor along a polyline. It keeps the range of slopes, relative to the direction
// in which it set out, at which it passes all points within the tolerance. Lengths are measured in that
// direction and scaled by its length, so that each edge costs one root, and no quotient before there is a
// slope.
class Edge {
 public:
  explicit Edge(double tolerance) : tolerance_(tolerance) {}
  void begin(Vec anchor, Vec place) {
    anchor_ = anchor;
    place_ = place;
    reach_ = kNoWay;
  }
  // @return the first point that the edge cannot reach, or the end
  const Vec* follow(const Vec* place, const Vec* end) {
    for (; reach_ == kNoWay && place != end; ++place)
      if (sets_out(*place)) break;
    while (place != end && reaches(*place, width_)) ++place;
    return place;
  }
  // Returns whether the edge can end at a point, or has not set out before it.
  bool closes(Vec place) { return (reach_ == kNoWay && !sets_out(place)) || reaches(place, 0.0); }
  // Returns the end beside the last point, in the middle of the range of slopes.
  Vec end() const {
    return anchor_ + (reach_ / square_) * (along_ + 0.5 * (left_ - right_) * left_of(along_));
  }
  bool empty() const { return reach_ <= kNothing; }

 private:
  bool sets_out(Vec p) {
    const Vec way = p - anchor_;
    along_ = p - place_;
    square_ = dot(along_, along_);
    if (dot(way, way) <= tolerance_ * tolerance_ || square_ == 0) return false;
    width_ = tolerance_ * std::sqrt(square_);
    reach_ = kNothing;
    left_ = right_ = kSteep;
    return true;
  }
  // One branch: its outcome is seldom predictable, and the side of a failure never.
  bool reaches(Vec p, double width) {
    const Vec way = p - anchor_;
    const double reach = dot(along_, way), side = cross(along_, way);
    const double left = side + width, right = width - side;
    if (int(reach < reach_) | int(left < -right_ * reach) | int(right < -left_ * reach)) return false;
    const double inverse = 1 / reach;
    left_ = std::min(left_, left * inverse);
    right_ = std::min(right_, right * inverse);
    reach_ = reach;
    return true;
  }
  static constexpr double kSteep = 1.0, kNoWay = -1, kNothing = 1e-300;
  double tolerance_, reach_ = kNoWay;  // kNothing: no point has been reached yet
  double left_ = 0, right_ = 0;        // maximum slope and minus the minimum slope
  Vec anchor_, place_, along_;
  double square_ = 0, width_ = 0;  // square of along_; scaled tolerance
};

}  // namespace

bool simplify_ring(std::span<const Vec> line, double tolerance, Rings& rings, Degenerate degenerate) {
  const std::size_t n = line.size();
  RingWriter out(rings, n + 1);
  if ((n > 4 || degenerate == Degenerate::kDrop) && tolerance > 0) {
    out.add(line[0]);
    Edge edge(tolerance);
    edge.begin(line[0], line[0]);
    for (const Vec *place = line.data() + 1, *const end = line.data() + n;;) {
      place = edge.follow(place, end);
      if (place == end && edge.closes(line[0])) break;
      if (edge.empty() && place == end) {
        out.add(line[0]);
        break;
      }
      const Vec from = edge.empty() ? *place++ : edge.end();
      out.add(from);
      edge.begin(from, place[-1]);
    }
    if (out.size() >= 3 && out.close() != 0) return true;
    out.clear();
    if (degenerate == Degenerate::kDrop) return false;
  }
  for (const Vec v : line) out.add(v);
  return out.close() != 0;
}

}  // namespace firn::geometry
