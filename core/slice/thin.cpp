#include "core/slice/thin.h"

namespace firn::slice {
namespace {

void add(Rings& rings, std::size_t begin, Vec v) {
  const Point p = to_point(v);
  if (rings.points.size() == begin || rings.points.back() != p) rings.points.push_back(p);
}

bool close(Rings& rings, std::size_t begin) {
  while (rings.points.size() > begin + 1 && rings.points.back() == rings.points[begin]) rings.points.pop_back();
  double area = 0;
  for (std::size_t i = begin + 1; i + 1 < rings.points.size(); ++i)
    area += cross(to_vec(rings.points[i]) - to_vec(rings.points[begin]),
                  to_vec(rings.points[i + 1]) - to_vec(rings.points[begin]));
  if (area == 0) {
    rings.points.resize(begin);
    return false;
  }
  rings.ends.push_back(std::uint32_t(rings.points.size()));
  return true;
}

// An edge that grows from an anchor along a line of places: the slopes, seen in the direction in which it set out, at which
// it passes all of them within the tolerance.
class Edge {
 public:
  explicit Edge(double tolerance) : tolerance_(tolerance) {}
  void begin(Vec anchor, Vec place) {
    anchor_ = anchor, place_ = place;
    reach_ = -1;
  }
  // @return whether the edge may go on to a place, or, with a tolerance of 0 there, end at it
  bool take(Vec p, double tolerance) {
    const Vec way = p - anchor_;
    if (reach_ < 0) {
      const Vec out = p - place_;
      if (dot(way, way) <= tolerance_ * tolerance_ || dot(out, out) == 0) return true;
      along_ = (1 / length(out)) * out;
      reach_ = 0, low_ = -kSteep, high_ = kSteep;
    }
    const double reach = dot(along_, way), side = cross(along_, way), below = side - tolerance, above = side + tolerance;
    if (reach <= 0 || reach < reach_ || below > high_ * reach || above < low_ * reach) return false;
    if (below > low_ * reach) low_ = below / reach;
    if (above < high_ * reach) high_ = above / reach;
    reach_ = reach;
    return true;
  }
  // Beside the place taken last: as far from either side as it may be.
  Vec end() const { return anchor_ + reach_ * (along_ + 0.5 * (low_ + high_) * left_of(along_)); }
  bool empty() const { return reach_ <= 0; }

 private:
  static constexpr double kSteep = 1.0;
  double tolerance_, reach_ = -1, low_ = 0, high_ = 0;
  Vec anchor_, place_, along_;
};

}  // namespace

bool thin_ring(std::span<const Vec> line, double tolerance, Rings& rings, Flat flat) {
  const std::size_t begin = rings.points.size(), n = line.size();
  if ((n > 4 || flat == Flat::kVanishes) && tolerance > 0) {
    add(rings, begin, line[0]);
    Edge edge(tolerance);
    Vec from = line[0];
    edge.begin(from, from);
    for (std::size_t i = 1; i <= n;) {
      const Vec to = line[i < n ? i : 0];
      if (edge.take(to, i < n ? tolerance : 0.0)) {
        ++i;
        continue;
      }
      if (edge.empty()) from = to, ++i;
      else from = edge.end();
      add(rings, begin, from);
      if (i <= n) edge.begin(from, line[i - 1]);
    }
    if (rings.points.size() - begin >= 3 && close(rings, begin)) return true;
    rings.points.resize(begin);
    if (flat == Flat::kVanishes) return false;
  }
  for (const Vec v : line) add(rings, begin, v);
  return close(rings, begin);
}

}  // namespace firn::slice
