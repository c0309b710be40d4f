#include "files/path/join_curves.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace firn {
namespace {

constexpr double kSame_mm = 1e-7;  ///< between ends that are the same but for rounding

class Joiner {
 public:
  explicit Joiner(const std::vector<DrawnCurve>& curves) : curves_(curves), used_(curves.size(), false) {
    for (std::size_t i = 0; i < curves.size(); ++i) {
      ends_[cell(curves[i].shape.points.front())].insert(i);
      ends_[cell(curves[i].shape.points.back())].insert(i);
    }
  }

  std::optional<JoinedCurve> path_from(std::size_t first) {
    if (used_[first]) return std::nullopt;
    const DrawnCurve& seed = curves_[first];
    take(first);
    std::vector<Part> after, before;
    grow(seed, seed.shape.points.back(), seed.shape.points.front(), after);
    const Point2 end = after.empty() ? seed.shape.points.back() : last(after.back());
    grow(seed, seed.shape.points.front(), end, before);
    JoinedCurve out{{}, seed.z_mm, seed.line, 1 + after.size() + before.size()};
    for (std::size_t k = before.size(); k-- > 0;) append({before[k].curve, !before[k].reversed}, out.shape);
    append({first, false}, out.shape);
    for (const Part& part : after) append(part, out.shape);
    std::vector<Point2>& points = out.shape.points;
    if (const double gap = distance(points.front(), points.back()); points.size() > 2 && gap <= kJoin_mm) {
      points.back() = points.front();
      auto& given = out.shape.given;
      if (gap > kSame_mm && !given.empty() && given.back().last + 1 == points.size()) given.pop_back();
    }
    return out;
  }

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  struct Part {
    std::size_t curve;
    bool reversed;
  };

  static Cell cell(Point2 p) {
    return {std::int64_t(std::floor(p.x_mm / kJoin_mm)), std::int64_t(std::floor(p.y_mm / kJoin_mm))};
  }
  Point2 last(const Part& part) const {
    const auto& points = curves_[part.curve].shape.points;
    return part.reversed ? points.front() : points.back();
  }

  void take(std::size_t i) {
    used_[i] = true;
    ends_[cell(curves_[i].shape.points.front())].erase(i);
    ends_[cell(curves_[i].shape.points.back())].erase(i);
  }

  /// Curves from `at` on, until `stop` closes the path.
  void grow(const DrawnCurve& seed, Point2 at, Point2 stop, std::vector<Part>& parts) {
    while (distance(at, stop) > kJoin_mm) {
      const std::optional<Part> next = find(seed, at);
      if (!next) return;
      take(next->curve);
      parts.push_back(*next);
      at = last(*next);
    }
  }

  std::optional<Part> find(const DrawnCurve& seed, Point2 at) const {
    const Cell centre = cell(at);
    std::optional<Part> best;
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = ends_.find({centre.first + dx, centre.second + dy});
        if (found == ends_.end()) continue;
        for (const std::size_t i : found->second) {
          if (best && i >= best->curve) break;
          const DrawnCurve& c = curves_[i];
          if (c.layer != seed.layer || std::abs(c.z_mm - seed.z_mm) > kJoin_mm) continue;
          const bool forward = distance(c.shape.points.front(), at) <= kJoin_mm;
          if (!forward && distance(c.shape.points.back(), at) > kJoin_mm) continue;
          best = Part{i, !forward};
          break;
        }
      }
    return best;
  }

  /// The first point of a further curve is the last one of that before; an arc or a Bezier curve that ends
  /// elsewhere is known by its points alone.
  void append(const Part& part, ShapedPoints& out) const {
    const ShapedPoints& from = curves_[part.curve].shape;
    std::vector<Point2> points = from.points;
    std::vector<GivenCurve> given = from.given;
    if (part.reversed) {
      std::reverse(points.begin(), points.end());
      std::reverse(given.begin(), given.end());
      for (GivenCurve& curve : given) {
        curve.clockwise = !curve.clockwise;
        std::swap(curve.start, curve.end);
        std::swap(curve.control[0], curve.control[1]);
        std::swap(curve.first, curve.last);
        curve.first = points.size() - 1 - curve.first;
        curve.last = points.size() - 1 - curve.last;
      }
    }
    const bool further = !out.points.empty();
    const bool same = !further || distance(out.points.back(), points.front()) <= kSame_mm;
    const std::size_t offset = out.points.size() - (further ? 1 : 0);
    for (GivenCurve& curve : given) {
      if (!same && curve.first == 0) continue;
      curve.first += offset;
      curve.last += offset;
      out.given.push_back(curve);
    }
    out.points.insert(out.points.end(), points.begin() + (further ? 1 : 0), points.end());
  }

  const std::vector<DrawnCurve>& curves_;
  std::vector<char> used_;
  std::map<Cell, std::set<std::size_t>> ends_;
};

}  // namespace

void join_curves(const std::vector<DrawnCurve>& curves, const std::function<void(JoinedCurve&&)>& sink) {
  Joiner joiner(curves);
  for (std::size_t i = 0; i < curves.size(); ++i)
    if (auto path = joiner.path_from(i)) sink(std::move(*path));
}

}  // namespace firn
