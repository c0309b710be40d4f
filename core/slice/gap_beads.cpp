#include "core/slice/gap_beads.h"

#include <algorithm>
#include <utility>

#include "core/slice/box_pairs.h"
#include "core/slice/middle_lines.h"
#include "core/slice/planar.h"

namespace firn::slice {
namespace {

constexpr double kLook = 0.6 * kUnitsPerMm;  // rings are asked at least so often how far the next level is
constexpr double kTip = 0.15 * kUnitsPerMm;   // from a tip to the foot beside it
constexpr double kTipFacing = -0.174;         // cosine between the normals of a tip's walls
constexpr double kTaper = 1.4;               // widest to narrowest place of one bead

double square_distance(Vec p, Vec a, Vec b) {
  const Vec way = b - a, off = p - a;
  const double square = dot(way, way), along = dot(off, way);
  if (along <= 0 || square == 0) return dot(off, off);
  if (along >= square) return dot(p - b, p - b);
  const double side = cross(way, off);
  return side * side / square;
}

// The next level, asked for its distance by places that follow each other. Keeps its working memory.
class NextLevel : public AxisField {
 public:
  /// @param reach of the level's beads to each side
  void take(const Rings& rings, double reach) {
    reach_ = reach;
    last_ = 0, lonely_square_ = 0, built_ = false;
    edges_.resize(rings.points.size());
    std::size_t begin = 0;
    for (const std::uint32_t end : rings.ends) {
      Vec b = to_vec(rings.points[begin]);
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t next = i + 1 < end ? i + 1 : begin;
        const Vec a = std::exchange(b, to_vec(rings.points[next])), way = b - a;
        const double square = dot(way, way);
        edges_[i] = {a, way, square > 0 ? 1 / square : 0.0, std::uint32_t(next)};
      }
      begin = end;
    }
  }

  bool empty() const { return edges_.empty(); }

  // Is the next level no further than this? Rings run side by side: the edge that was near the last place is a guess.
  bool within(Vec p, double limit) {
    const double square = limit * limit;
    const std::size_t n = edges_.size();
    if (n == 0 || dot(p - lonely_, p - lonely_) < lonely_square_) return false;
    for (std::size_t back = last_, ahead = last_, tried = 0; tried < kGuesses; ++tried) {
      const std::size_t e = tried % 2 ? back : ahead;
      if (edges_[e].within(p, square)) {
        last_ = e;
        return true;
      }
      if (tried % 2 == 0) ahead = ahead + 1 < n ? ahead + 1 : 0;
      if (tried % 2 || tried == 0) back = back ? back - 1 : n - 1;
    }
    // Places nearer to this one than it is too far from the next level are too far as well.
    const double found = clearance(p, limit + kLonely - reach_) + reach_;
    if (found <= limit) return true;
    lonely_ = p, lonely_square_ = (found - limit) * (found - limit);
    return false;
  }

  // Is the whole way from a to b near? a is, to the edge found last. The distance from a segment is convex along a line:
  // an edge that is near a and a corner's foot on the way is near all between, and the corner's next edge goes on.
  bool way_within(Vec a, Vec b, double limit) {
    const double square = limit * limit;
    std::size_t e = last_;
    for (std::size_t steps = 0; steps < kGuesses; ++steps, e = edges_[e].next) {
      if (edges_[e].within(b, square)) {
        last_ = e;
        return true;
      }
      if (square_distance(edges_[edges_[e].next].at, a, b) > square) return false;
    }
    return false;
  }

  double clearance(Vec p, double limit) override {
    if (edges_.empty()) return limit;
    const double furthest = limit + reach_;
    double best = std::min(furthest * furthest, edges_[last_].square_distance(p));
    touching(p, std::sqrt(best), [&](std::size_t e) {
      const double square = edges_[e].square_distance(p);
      if (square < best) best = square, last_ = e;
    });
    return std::sqrt(best) - reach_;
  }

 private:
  static constexpr std::size_t kGuesses = 5;
  static constexpr double kLonely = 3.0 * kUnitsPerMm;

  struct Edge {
    Vec at, way;
    double inverse;      // of its squared length
    std::uint32_t next;  // in its ring
    double square_distance(Vec p) const {  // without a branch
      const Vec off = p - at;
      const double share = std::min(1.0, std::max(0.0, dot(off, way) * inverse));
      const Vec from = off - share * way;
      return dot(from, from);
    }
    bool within(Vec p, double limit) const { return square_distance(p) <= limit; }
  };

  template <class F>
  void touching(Vec p, double reach, F&& f) {
    if (edges_.empty()) return;
    if (!built_) {
      tree_.resize(edges_.size());
      for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Point from = to_point(edges_[i].at), to = to_point(edges_[i].at + edges_[i].way);
        tree_.set(i, std::min(from.x, to.x), std::min(from.y, to.y), std::max(from.x, to.x), std::max(from.y, to.y));
      }
      tree_.build();
      built_ = true;
    }
    tree_.touching(box_about(p.x, p.y, reach), f);
  }

  double reach_ = 0;
  std::vector<Edge> edges_;
  std::size_t last_ = 0;
  Vec lonely_;
  double lonely_square_ = 0;
  BoxTree tree_;
  bool built_ = false;
};

// No disc that ends at the covered edge and is wide enough fits into a ring this small.
bool too_small(std::span<const Point> ring, double least) {
  BoxOf<std::int32_t> box;
  for (const Point p : ring) box.add(p.x, p.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * least;
}

// Stretches of rings along which the next level is further away than it runs. Keeps its working memory.
class Lacking {
 public:
  explicit Lacking(NextLevel& next) : next_(next) {}

  /// @param limit distance of the next level beyond which a place lacks it
  /// @param cores whether the rings are cores
  void begin(double limit, bool cores) {
    limit_ = limit, cores_ = cores;
    run_ = 0;
    walls.clear();
    feet.clear();
  }

  void add(std::span<const Point> ring) {
    const std::size_t n = ring.size();
    looks_.clear();
    fresh_ = false;
    Vec a = to_vec(ring[0]);
    const bool first_served = next_.within(a, limit_);
    bool served = first_served;
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec b = to_vec(ring[i + 1 < n ? i + 1 : 0]);
      if (!look(a, i, 0, served) || !next_.way_within(a, b, limit_)) {
        const double l = length(b - a);
        const int looks = l > kLook ? 2 * int(0.5 * l / kLook) + 1 : 0;  // one of them in the middle
        look_along(a, b - a, i, looks, 0, looks);
        served = i + 1 < n ? next_.within(b, limit_) : first_served;
      }
      a = b;
    }
    if (looks_.empty()) return;
    corners_.resize(n);
    normals_.resize(n);
    wall_of_.assign(n, -1);
    for (std::size_t i = 0; i < n; ++i) corners_[i] = to_vec(ring[i]);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec way = corners_[i + 1 < n ? i + 1 : 0] - corners_[i];
      normals_[i] = (1 / length(way)) * left_of(way);
    }
    // A stretch that runs over the ring's first point is one.
    const auto first = std::find_if(looks_.begin(), looks_.end(), [](const Look& l) { return l.fresh; });
    if (first == looks_.end()) {
      add_stretch(looks_, !fresh_);
      return;
    }
    if (!fresh_) std::rotate(looks_.begin(), first, looks_.end());
    for (std::size_t i = 0, end; i < looks_.size(); i = end) {
      for (end = i + 1; end < looks_.size() && !looks_[end].fresh; ++end) {
      }
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
    bool fresh;    // lies behind something that lacks nothing
  };

  bool look(Vec at, std::uint32_t edge, double share, bool served) {
    if (!served) looks_.push_back({at, edge, share, fresh_});
    fresh_ = served;
    return served;
  }

  // Looks [begin, end) of `looks` on an edge, in halves: what lacks is mostly near corners.
  void look_along(Vec a, Vec way, std::uint32_t edge, int looks, int begin, int end) {
    const auto share = [&](int k) { return (k + 0.5) / looks; };
    const auto at = [&](int k) { return a + share(k) * way; };
    if (end - begin > 3) {
      if (next_.within(at(begin), limit_) && next_.way_within(at(begin), at(end - 1), limit_)) {
        fresh_ = true;
        return;
      }
      const int middle = begin + (end - begin) / 2;
      look_along(a, way, edge, looks, begin, middle);
      look_along(a, way, edge, looks, middle, end);
      return;
    }
    for (int k = begin; k < end; ++k) look(at(k), edge, share(k), next_.within(at(k), limit_));
  }

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

  // A corner looks between its walls' normals, if it is smooth; a reflex one in all directions between them. In the tips of
  // cores only a foot beside them sees what is left.
  void add_corner(std::uint32_t edge, std::int32_t wall) {
    const Vec from = normals_[edge ? edge - 1 : normals_.size() - 1], to = normals_[edge];
    const bool reflex = cross(from, to) < 0, back = dot(from, to) < -0.9;
    if (!reflex && dot(from, to) < 0.5) {
      if (!cores_ || dot(from, to) > kTipFacing) return;
      const Vec way = corners_[edge + 1 < corners_.size() ? edge + 1 : 0] - corners_[edge];
      const double share = std::min(0.25, kTip / length(way));
      feet.push_back({corners_[edge] + share * way, to, wall + share, run_});
      return;
    }
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
  double limit_ = 0;
  bool cores_ = false;
  bool fresh_ = false;  // was the last place served?
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

GapBand core_band(const RingPlan& plan, int level, double spot_mm) {
  const double core_mm = plan.core_mm(level, spot_mm);
  return {-0.5 * spot_mm, plan.distance_mm(level + 1) - core_mm, core_mm - plan.distance_mm(level)};
}

class GapFinder::Work {
 public:
  Beads find(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm, double tolerance_mm) {
    const double narrowest = 0.5 * narrowest_mm * kUnitsPerMm, tolerance = std::max(100.0, tolerance_mm * kUnitsPerMm);
    const double drawn = 2.2 * tolerance + 200;  // both levels are drawn within the tolerance
    const AxisLimits limits{band.covered_mm * kUnitsPerMm, band.next_mm * kUnitsPerMm, narrowest, drawn, band.inside_mm * kUnitsPerMm};
    next_.take(next, limits.next - limits.covered);  // the next level's beads reach so far to each side
    lacking_.begin(limits.next + drawn, limits.inside > 0);
    for (std::size_t r = 0; r < outer.size(); ++r)
      if (outer[r].size() > 2 && !(too_small(outer[r], limits.covered + narrowest) && twice_area(outer[r]) > 0)) lacking_.add(outer[r]);
    Beads beads;
    for (const std::vector<AxisPlace>& chain : middle_(lacking_.walls, lacking_.feet, limits, next_))
      add_chain(chain, 0.5 * tolerance, beads);
    return beads;
  }

 private:
  NextLevel next_;
  Lacking lacking_{next_};
  MiddleLines middle_;
};

GapFinder::GapFinder() : work_(std::make_unique<Work>()) {}
GapFinder::~GapFinder() = default;

Beads GapFinder::operator()(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm,
                            double tolerance_mm, bool touching) {
  if (outer.empty() || narrowest_mm <= 0) return {};
  return work_->find(touching ? region_of(outer) : outer, next, band, narrowest_mm, tolerance_mm);
}

}  // namespace firn::slice
