#include "files/path/join_curves.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace firn {
namespace {

class Joiner {
 public:
  explicit Joiner(const std::vector<DrawnCurve>& curves) : curves_(curves), used_(curves.size(), false) {
    for (std::size_t i = 0; i < curves.size(); ++i) {
      ends_[cell(curves[i].points.front())].insert(i);
      ends_[cell(curves[i].points.back())].insert(i);
    }
  }

  std::optional<JoinedCurve> path_from(std::size_t first) {
    if (used_[first]) return std::nullopt;
    const DrawnCurve& seed = curves_[first];
    take(first);
    std::vector<Part> after, before;
    grow(seed, seed.points.back(), seed.points.front(), after);
    const Point2 end = after.empty() ? seed.points.back() : last(after.back());
    grow(seed, seed.points.front(), end, before);
    JoinedCurve out{{}, seed.z_mm, seed.line, 1 + after.size() + before.size()};
    for (std::size_t k = before.size(); k-- > 0;) append({before[k].curve, !before[k].reversed}, out.points);
    append({first, false}, out.points);
    for (const Part& part : after) append(part, out.points);
    if (out.points.size() > 2 && distance(out.points.front(), out.points.back()) <= kJoin_mm)
      out.points.back() = out.points.front();
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
    const auto& points = curves_[part.curve].points;
    return part.reversed ? points.front() : points.back();
  }

  void take(std::size_t i) {
    used_[i] = true;
    ends_[cell(curves_[i].points.front())].erase(i);
    ends_[cell(curves_[i].points.back())].erase(i);
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
          if (c.layer != seed.layer || c.z_mm != seed.z_mm) continue;
          const bool forward = distance(c.points.front(), at) <= kJoin_mm;
          if (!forward && distance(c.points.back(), at) > kJoin_mm) continue;
          best = Part{i, !forward};
          break;
        }
      }
    return best;
  }

  /// The first point of a further curve is the last one of that before.
  void append(const Part& part, std::vector<Point2>& out) const {
    const auto& points = curves_[part.curve].points;
    const std::size_t skip = out.empty() ? 0 : 1;
    if (part.reversed)
      out.insert(out.end(), points.rbegin() + std::ptrdiff_t(skip), points.rend());
    else
      out.insert(out.end(), points.begin() + std::ptrdiff_t(skip), points.end());
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
