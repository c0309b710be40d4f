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

}  // namespace

bool thin_ring(std::span<const Vec> line, double tolerance, Rings& rings) {
  const std::size_t begin = rings.points.size(), n = line.size();
  if (n > 4 && tolerance > 0) {
    // From the point with the smallest x, an extreme that stays.
    std::size_t first = 0;
    for (std::size_t i = 1; i < n; ++i)
      if (line[i].x < line[first].x || (line[i].x == line[first].x && line[i].y < line[first].y)) first = i;
    const auto at = [&](std::size_t i) { return line[first + i < n ? first + i : first + i - n]; };
    const double square = tolerance * tolerance;
    Vec anchor = at(0);
    add(rings, begin, anchor);
    Vec low, high;  // directions between which all skipped points lie within the tolerance
    bool open = true;
    double furthest = 0;
    for (std::size_t i = 1; i <= n; ++i) {
      Vec to = at(i < n ? i : 0) - anchor;
      double r2 = dot(to, to);
      const bool fits = r2 >= furthest && (open || (cross(low, to) >= 0 && cross(to, high) >= 0));
      if (!fits) {
        anchor = at(i - 1);
        add(rings, begin, anchor);
        open = true;
        furthest = 0;
        to = at(i < n ? i : 0) - anchor;
        r2 = dot(to, to);
      }
      furthest = r2;
      if (r2 <= square) continue;
      const double root = std::sqrt(r2 - square);
      const Vec across = tolerance * left_of(to);
      const Vec right = root * to - across, left = root * to + across;
      if (open || cross(low, right) > 0) low = right;
      if (open || cross(left, high) > 0) high = left;
      open = false;
    }
    if (rings.points.size() - begin >= 3 && close(rings, begin)) return true;
    rings.points.resize(begin);
  }
  for (const Vec v : line) add(rings, begin, v);
  return close(rings, begin);
}

}  // namespace firn::slice
