#include "core/slice/gap_beads.h"

#include <algorithm>

#include "core/slice/box_pairs.h"
#include "core/slice/middle_lines.h"
#include "core/slice/planar.h"

namespace firn::slice {
namespace {

constexpr double kLook = 0.5 * kUnitsPerMm;  // rings are asked at least so often how far the next level is
constexpr double kTaper = 1.4;               // widest to narrowest place of one bead

double square_distance(Vec p, Vec a, Vec b) {
  const Vec way = b - a, off = p - a;
  const double square = dot(way, way), along = dot(off, way);
  if (along <= 0 || square == 0) return dot(off, off);
  if (along >= square) return dot(p - b, p - b);
  const double side = cross(way, off);
  return side * side / square;
}

// The next level, asked for its distance by places that follow each other.
class NextLevel : public AxisField {
 public:
  /// @param reach of the level's beads to each side
  NextLevel(const Rings& rings, double reach) : reach_(reach) {
    std::size_t begin = 0;
    a_.reserve(rings.points.size());
    b_.reserve(rings.points.size());
    for (const std::uint32_t end : rings.ends) {
      for (std::size_t i = begin; i < end; ++i) {
        a_.push_back(to_vec(rings.points[i]));
        b_.push_back(to_vec(rings.points[i + 1 < end ? i + 1 : begin]));
      }
      begin = end;
    }
  }

  // Is the next level no further than `limit`? Rings run side by side: the edge that was near the last place is a guess.
  bool within(Vec p, double limit) {
    const double square = limit * limit;
    const std::size_t n = a_.size();
    for (std::size_t tried = 0; tried < std::min<std::size_t>(n, kGuesses); ++tried) {
      // Here, one on, one back, two on, ...
      const std::size_t off = (tried + 1) / 2, e = tried % 2 ? (last_ + off) % n : (last_ + n - off) % n;
      if (square_distance(p, a_[e], b_[e]) > square) continue;
      last_ = e;
      return true;
    }
    bool found = false;
    touching(p, limit, [&](std::size_t e) {
      if (found || square_distance(p, a_[e], b_[e]) > square) return;
      found = true;
      last_ = e;
    });
    return found;
  }

  double clearance(Vec p, double limit) override {
    double best = (limit + reach_) * (limit + reach_);
    touching(p, limit + reach_, [&](std::size_t e) { best = std::min(best, square_distance(p, a_[e], b_[e])); });
    return std::sqrt(best) - reach_;
  }

 private:
  static constexpr std::size_t kGuesses = 7;

  template <class F>
  void touching(Vec p, double reach, F&& f) {
    if (a_.empty()) return;
    if (!built_) {
      tree_.leaves().resize(a_.size());
      for (std::size_t i = 0; i < a_.size(); ++i) {
        BoxOf<double> box;
        box.add(a_[i].x, a_[i].y), box.add(b_[i].x, b_[i].y);
        tree_.leaves()[i] = box;
      }
      tree_.build();
      built_ = true;
    }
    tree_.touching({p.x - reach, p.y - reach, p.x + reach, p.y + reach}, f);
  }

  double reach_;
  std::vector<Vec> a_, b_;
  std::size_t last_ = 0;
  BoxTree<double> tree_;
  bool built_ = false;
};

// No disc that ends at the covered edge and is wide enough fits into a ring this small.
bool too_small(std::span<const Point> ring, double least) {
  BoxOf<std::int32_t> box;
  for (const Point p : ring) box.add(p.x, p.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * least;
}

// Stretches of rings along which the next level is further away than it runs.
class Lacking {
 public:
  /// @param limit distance of the next level beyond which a place lacks it
  Lacking(NextLevel& next, double limit) : next_(next), limit_(limit) {}

  void add(std::span<const Point> ring) {
    const std::size_t n = ring.size();
    corners_.resize(n);
    normals_.resize(n);
    for (std::size_t i = 0; i < n; ++i) corners_[i] = to_vec(ring[i]);
    wall_of_.assign(n, -1);
    looks_.clear();
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec a = corners_[i], way = corners_[i + 1 < n ? i + 1 : 0] - a;
      const double l = length(way);
      normals_[i] = (1 / l) * left_of(way);
      looks_.push_back({a, i, 0, next_.within(a, limit_)});
      if (l < kLook) continue;
      const int looks = 2 * int(0.5 * l / kLook) + 1;  // one of them in the middle
      for (int k = 0; k < looks; ++k) {
        const double share = (k + 0.5) / looks;
        const Vec at = a + share * way;
        looks_.push_back({at, i, share, next_.within(at, limit_)});
      }
    }
    // From a place that lacks nothing, so that no stretch is cut in two.
    const auto first = std::find_if(looks_.begin(), looks_.end(), [](const Look& l) { return l.served; });
    if (first == looks_.end()) {
      add_stretch(looks_, true);
      return;
    }
    std::rotate(looks_.begin(), first, looks_.end());
    for (std::size_t i = 0, end; i < looks_.size(); i = end) {
      end = i + 1;
      if (looks_[i].served) continue;
      while (end < looks_.size() && !looks_[end].served) ++end;
      add_stretch(std::span(looks_).subspan(i, end - i), false);
    }
  }

  std::vector<Wall> walls;
  std::vector<Foot> feet;

 private:
  struct Look {
    Vec at;
    std::uint32_t edge;
    double share;  // of the way along it
    bool served;
  };

  std::int32_t add_wall(std::size_t edge, bool sampled) {
    std::int32_t& wall = wall_of_[edge];
    if (wall < 0) {
      wall = std::int32_t(walls.size());
      walls.push_back({corners_[edge], corners_[edge + 1 < corners_.size() ? edge + 1 : 0], normals_[edge], false});
    }
    walls[std::size_t(wall)].sampled |= sampled;
    return wall;
  }

  void add_stretch(std::span<const Look> looks, bool whole) {
    const std::size_t n = corners_.size();
    if (!whole) add_wall((looks[0].edge + n - 1) % n, false);
    for (const Look& look : looks) {
      const std::int32_t wall = add_wall(look.edge, true);
      if (look.share == 0) add_corner(look.edge, wall);
      else feet.push_back({look.at, normals_[look.edge], wall + look.share, run_});
    }
    if (!whole) add_wall((looks.back().edge + 1) % n, false);
    ++run_;
  }

  // A corner looks between its walls' normals, if it is smooth; a reflex one in all directions between them.
  void add_corner(std::uint32_t edge, std::int32_t wall) {
    const Vec from = normals_[edge ? edge - 1 : normals_.size() - 1], to = normals_[edge];
    const bool reflex = cross(from, to) < 0, back = dot(from, to) < -0.9;
    if (!reflex && dot(from, to) < 0.5) return;
    const int steps = reflex ? std::max(2, int(std::ceil(length(to - from) * limit_ / kLook))) : 2;
    for (int k = 1; k < steps; ++k) {
      const double share = double(k) / steps;
      // By way of the middle direction, were the sum to vanish.
      const Vec turned = back ? 2 * std::min(share, 1 - share) * left_of(to - from) : Vec{};
      const Vec normal = (1 - share) * from + share * to + turned;
      const double l = length(normal);
      if (l > 0) feet.push_back({corners_[edge], (1 / l) * normal, double(wall), run_});
    }
  }

  NextLevel& next_;
  double limit_;
  std::vector<Vec> corners_, normals_;
  std::vector<Look> looks_;
  std::vector<std::int32_t> wall_of_;  // each edge
  std::int32_t run_ = 0;
};

// Douglas and Peucker's, of the places from `begin` to `last`; appends all kept but the last.
void thin(std::span<const AxisPlace> places, std::size_t begin, std::size_t last, double tolerance, std::vector<Point>& out) {
  double worst = tolerance * tolerance;
  std::size_t at = begin;
  for (std::size_t i = begin + 1; i < last; ++i) {
    const double d = square_distance(places[i].at, places[begin].at, places[last].at);
    if (d > worst) worst = d, at = i;
  }
  if (at == begin) {
    out.push_back(to_point(places[begin].at));
    return;
  }
  thin(places, begin, at, tolerance, out);
  thin(places, at, last, tolerance, out);
}

void add_chain(std::span<const AxisPlace> chain, double tolerance, Beads& beads) {
  std::vector<Point> line;
  for (std::size_t begin = 0; begin + 1 < chain.size();) {
    double low = chain[begin].radius, high = low, way = 0;
    std::size_t last = begin;
    while (last + 1 < chain.size()) {
      const double radius = chain[last + 1].radius, l = std::min(low, radius), h = std::max(high, radius);
      if (h > kTaper * l && way > high) break;
      way += length(chain[last + 1].at - chain[last].at);
      low = l, high = h, ++last;
    }
    line.clear();
    thin(chain, begin, last, tolerance, line);
    line.push_back(to_point(chain[last].at));
    line.erase(std::unique(line.begin(), line.end()), line.end());
    if (line.size() > 1) {
      beads.lines.add(line);
      beads.widths.push_back(std::int32_t(std::ceil(2 * high)));
    }
    begin = last;
  }
}

}  // namespace

GapBand gap_band(const RingPlan& plan, int level) {
  if (level < 0) return {plan.first_mm - 0.5 * plan.width_mm(0), plan.first_mm};
  return {0.5 * plan.width_mm(level), plan.distance_mm(level + 1) - plan.distance_mm(level)};
}

Beads gap_beads(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm, double tolerance_mm,
                bool touching) {
  Beads beads;
  if (outer.empty() || narrowest_mm <= 0) return beads;
  const double narrowest = 0.5 * narrowest_mm * kUnitsPerMm, tolerance = std::max(100.0, tolerance_mm * kUnitsPerMm);
  const AxisLimits limits{band.covered_mm * kUnitsPerMm, band.next_mm * kUnitsPerMm, narrowest};
  const double reach = limits.next - limits.covered;  // of the next level's beads, to each side
  NextLevel level(next, reach);
  Lacking lacking(level, limits.next + 2.2 * tolerance + 200);  // both levels are drawn within the tolerance
  const Rings apart = touching ? region_of(outer) : Rings{};
  const Rings& rings = touching ? apart : outer;
  for (std::size_t r = 0; r < rings.size(); ++r)
    if (rings[r].size() > 2 && !(too_small(rings[r], limits.covered + narrowest) && twice_area(rings[r]) > 0)) lacking.add(rings[r]);
  for (const std::vector<AxisPlace>& chain : middle_lines(lacking.walls, lacking.feet, limits, level))
    add_chain(chain, 0.5 * tolerance, beads);
  return beads;
}

}  // namespace firn::slice
