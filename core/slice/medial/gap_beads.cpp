#include "core/slice/medial/gap_beads.h"

#include <algorithm>
#include <utility>

#include "core/slice/medial/feet.h"
#include "core/slice/medial/middle_lines.h"
#include "core/slice/medial/next_level.h"
#include "core/geometry/planar.h"

namespace firn::slice {
namespace {

constexpr double kLook = 0.6 * kUnitsPerMm;   // rings are asked at least so often how far the next level is
constexpr double kMoved = 0.5 * kUnitsPerMm;  // furthest that a corner is drawn from where the front has it
constexpr double kTaper = 1.4;                // widest to narrowest place of one bead

// No disc that ends at the covered edge and is wide enough fits into a ring this small.
bool too_small(std::span<const Point> ring, double least) {
  BoxOf<std::int32_t> box;
  for (const Point p : ring) box.add(p.x, p.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * least;
}

// Stretches of drawn rings along which the next level is further away than it runs. Keeps its working memory.
class Lacking {
 public:
  explicit Lacking(NextLevel& next) : next_(next) {}

  /// @param limit distance of the next level beyond which a place lacks it
  void add(std::span<const Point> ring, double limit, Stretches& stretches) {
    const std::size_t n = ring.size();
    limit_ = limit;
    looks_.clear();
    fresh_ = false;
    Vec a = to_vec(ring[0]);
    const bool first_served = next_.within(a, limit_);
    bool served = first_served;
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec b = to_vec(ring[i + 1 < n ? i + 1 : 0]);
      if (!look(a, i, served) || !next_.way_within(a, b, limit_)) {
        const double l = length(b - a);
        const int looks = l > kLook ? 2 * int(0.5 * l / kLook) + 1 : 0;  // one of them in the middle
        look_along(a, b - a, i, looks, 0, looks);
        served = i + 1 < n ? next_.within(b, limit_) : first_served;
      }
      a = b;
    }
    if (looks_.empty()) return;
    // A stretch that runs over the ring's first point is one.
    const auto first = std::find_if(looks_.begin(), looks_.end(), [](const Look& l) { return l.fresh; });
    if (first == looks_.end() && !fresh_) {
      add_all(ring, stretches);
      return;
    }
    if (first != looks_.end() && !fresh_) std::rotate(looks_.begin(), first, looks_.end());
    for (std::size_t i = 0, end; i < looks_.size(); i = end) {
      for (end = i + 1; end < looks_.size() && !looks_[end].fresh; ++end) {
      }
      add_stretch(ring, looks_[i], looks_[end - 1], stretches);
    }
  }

 private:
  struct Look {
    Vec at;
    std::uint32_t edge;
    bool fresh;  // lies behind something that lacks nothing
  };

  bool look(Vec at, std::uint32_t edge, bool served) {
    if (!served) looks_.push_back({at, edge, fresh_});
    fresh_ = served;
    return served;
  }

  // Looks [begin, end) of `looks` on an edge, in halves: what lacks is mostly near corners.
  void look_along(Vec a, Vec way, std::uint32_t edge, int looks, int begin, int end) {
    const auto at = [&](int k) { return a + ((k + 0.5) / looks) * way; };
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
    for (int k = begin; k < end; ++k) look(at(k), edge, next_.within(at(k), limit_));
  }

  static void add_all(std::span<const Point> ring, Stretches& stretches) {
    for (const Point p : ring) stretches.points.push_back(to_vec(p));
    stretches.all.push_back(
        {std::uint32_t(stretches.points.size()), 0, std::uint32_t(ring.size()), true, false, {}, false});
  }

  static void add_stretch(std::span<const Point> ring, const Look& from, const Look& to,
                          Stretches& stretches) {
    std::vector<Vec>& points = stretches.points;
    const std::size_t n = ring.size(), begin = points.size();
    const auto add = [&](Vec p) {
      if (points.size() == begin || dot(p - points.back(), p - points.back()) > 0) points.push_back(p);
      return std::uint32_t(points.size() - 1 - begin);
    };
    const auto corner = [&](std::size_t i) { return to_vec(ring[i < n ? i : i - n]); };
    add(corner(from.edge + n - 1));
    add(corner(from.edge));
    const std::uint32_t first = add(from.at);
    const std::size_t edges = to.edge >= from.edge ? to.edge - from.edge : to.edge + n - from.edge;
    for (std::size_t i = 1; i <= edges; ++i) add(corner((from.edge + i) % n));
    std::uint32_t last = add(to.at);
    add(corner((to.edge + 1) % n));
    const std::uint32_t behind = add(corner((to.edge + 2) % n));
    stretches.all.push_back({std::uint32_t(points.size()),
                             first,
                             std::max(last, std::min(first + 1, behind)),
                             false,
                             false,
                             {},
                             false});
  }

  NextLevel& next_;
  double limit_ = 0;
  bool fresh_ = false;  // was the last place served?
  std::vector<Look> looks_;
};

// The next level, where its nearest place is known.
class OneCorner : public AxisField {
 public:
  OneCorner(Vec at, double reach) : at_(at), reach_(reach) {}
  double clearance(Vec place, double limit) override { return std::min(limit, length(place - at_) - reach_); }

 private:
  Vec at_;
  double reach_;
};

// Douglas and Peucker's, of the places from `begin` to `last`; appends all kept but the last.
void thin(std::span<const MedialPlace> places, std::size_t begin, std::size_t last, double tolerance,
          std::vector<Point>& out) {
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

void add_chain(std::span<const MedialPlace> chain, double tolerance, std::vector<Point>& line, Beads& beads) {
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

class GapFinder::Work {
 public:
  void find(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm,
            double tolerance_mm, Beads& beads) {
    const GapLimits limits = gap_limits(band, narrowest_mm, tolerance_mm);
    next_.take(next, limits.axis.next - limits.axis.covered);
    stretches_.clear();
    for (std::size_t r = 0; r < outer.size(); ++r)
      if (outer[r].size() > 2 &&
          !(too_small(outer[r], limits.axis.covered + limits.axis.narrowest) && twice_area(outer[r]) > 0))
        lacking_.add(outer[r], limits.near, stretches_);
    lay(stretches_, limits, tolerance_mm, beads);
  }

  void find(Stretches& stretches, const Rings& next, const GapBand& band, double narrowest_mm,
            double tolerance_mm, Beads& beads) {
    if (stretches.empty()) return;
    const GapLimits limits = gap_limits(band, narrowest_mm, tolerance_mm);
    next_.take(next, limits.axis.next - limits.axis.covered);
    lay(stretches, limits, tolerance_mm, beads);
  }

 private:
  void lay(Stretches& stretches, const GapLimits& limits, double tolerance_mm, Beads& beads) {
    const double chain_tolerance = 0.5 * std::max(100.0, tolerance_mm * kUnitsPerMm);
    feet_.begin(limits.near, limits.spot_at, limits.enough, limits.axis.inside > 0);
    const std::span<Stretches::Stretch> all = stretches.all;
    const auto add_lines = [&](AxisField& field) {
      if (feet_.feet.empty()) return;
      for (const std::vector<MedialPlace>& chain : middle_(feet_.walls, feet_.feet, limits.axis, field))
        add_chain(chain, chain_tolerance, line_, beads);
    };
    for (std::size_t i = 0, end; i < all.size(); i = end) {
      bool open = false;
      for (end = i; end < all.size() && (end == i || !all[end].leads); ++end) {
        Stretches::Stretch& stretch = all[end];
        if (stretch.cornered && stretches.tips_moved) stretch.cornered = next_.snap(stretch.ahead, kMoved);
        open = open || !stretch.cornered;
        if (!stretch.cornered) continue;
        feet_.clear();
        feet_.add(points_of(stretches, end), stretch);
        OneCorner corner(stretch.ahead, limits.axis.next - limits.axis.covered);
        add_lines(corner);
      }
      if (!open) continue;
      feet_.clear();
      for (std::size_t k = i; k < end; ++k) {
        if (all[k].cornered)
          feet_.add_walls(points_of(stretches, k), all[k]);
        else
          feet_.add(points_of(stretches, k), all[k]);
      }
      add_lines(next_);
    }
  }

  static std::span<const Vec> points_of(const Stretches& stretches, std::size_t i) {
    const std::size_t begin = i ? stretches.all[i - 1].end : 0;
    return std::span(stretches.points).subspan(begin, stretches.all[i].end - begin);
  }

  NextLevel next_;
  Lacking lacking_{next_};
  Feet feet_{next_};
  MiddleLines middle_;
  Stretches stretches_;
  std::vector<Point> line_;
};

GapFinder::GapFinder() : work_(std::make_unique<Work>()) {}
GapFinder::~GapFinder() = default;

void GapFinder::operator()(const Rings& outer, const Rings& next, const GapBand& band, double narrowest_mm,
                           double tolerance_mm, bool touching, Beads& beads) {
  if (outer.empty() || narrowest_mm <= 0) return;
  work_->find(touching ? region_of(outer) : outer, next, band, narrowest_mm, tolerance_mm, beads);
}

void GapFinder::operator()(Stretches& lacking, const Rings& next, const GapBand& band, double narrowest_mm,
                           double tolerance_mm, Beads& beads) {
  work_->find(lacking, next, band, narrowest_mm, tolerance_mm, beads);
}

}  // namespace firn::slice
