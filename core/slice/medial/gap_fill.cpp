#include "core/slice/medial/gap_fill.h"

#include <algorithm>
#include <utility>

#include "core/geometry/planar.h"
#include "core/slice/medial/boundary_sampler.h"
#include "core/slice/medial/medial_axis.h"
#include "core/slice/medial/next_level.h"

namespace firn::slice {
namespace {

constexpr double kLook =
    0.6 * geometry::kUnitsPerMm;  // maximum spacing of the points of a ring that are tested
constexpr double kMoved =
    0.5 * geometry::kUnitsPerMm;  // maximum distance between a corner as drawn and in the wavefront
constexpr double kTaper = 1.4;    // maximum to minimum width of one line

// Returns whether a ring is too small for any disc of the minimum width that ends at the covered edge.
bool too_small(std::span<const geometry::Point> ring, double least) {
  geometry::BoxOf<std::int32_t> box;
  for (const geometry::Point p : ring) box.add(p.x, p.y);
  return std::min(box.x1 - box.x0, box.y1 - box.y0) < 2 * least;
}

// RingGapScan finds the chains of drawn rings from which the next level is too far away. Keeps its working
// memory.
class RingGapScan {
 public:
  explicit RingGapScan(NextLevel& next) : next_(next) {}

  /// @param limit distance of the next level beyond which a point is not served
  void add(std::span<const geometry::Point> ring, double limit, geometry::BoundaryChains& chains) {
    const std::size_t n = ring.size();
    limit_ = limit;
    looks_.clear();
    fresh_ = false;
    geometry::Vec a = to_vec(ring[0]);
    const bool first_served = next_.within(a, limit_);
    bool covered = first_served;
    for (std::uint32_t i = 0; i < n; ++i) {
      const geometry::Vec b = to_vec(ring[i + 1 < n ? i + 1 : 0]);
      if (!look(a, i, covered) || !next_.way_within(a, b, limit_)) {
        const double l = length(b - a);
        const int looks = l > kLook ? 2 * int(0.5 * l / kLook) + 1 : 0;  // one in the middle
        look_along(a, b - a, i, looks, 0, looks);
        covered = i + 1 < n ? next_.within(b, limit_) : first_served;
      }
      a = b;
    }
    if (looks_.empty()) return;
    // A chain that contains the first point of the ring is one.
    const auto first = std::find_if(looks_.begin(), looks_.end(), [](const Look& l) { return l.fresh; });
    if (first == looks_.end() && !fresh_) {
      add_all(ring, chains);
      return;
    }
    if (first != looks_.end() && !fresh_) std::rotate(looks_.begin(), first, looks_.end());
    for (std::size_t i = 0, end; i < looks_.size(); i = end) {
      for (end = i + 1; end < looks_.size() && !looks_[end].fresh; ++end) {
      }
      add_chain(ring, looks_[i], looks_[end - 1], chains);
    }
  }

 private:
  struct Look {
    geometry::Vec at;
    std::uint32_t edge;
    bool fresh;  // follows a point that is served
  };

  bool look(geometry::Vec at, std::uint32_t edge, bool covered) {
    if (!covered) looks_.push_back({at, edge, fresh_});
    fresh_ = covered;
    return covered;
  }

  // Tests points [begin, end) of `looks` on an edge by bisection, since unserved points are mostly near
  // corners.
  void look_along(geometry::Vec a, geometry::Vec way, std::uint32_t edge, int looks, int begin, int end) {
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

  static void add_all(std::span<const geometry::Point> ring, geometry::BoundaryChains& chains) {
    for (const geometry::Point p : ring) chains.points.push_back(to_vec(p));
    chains.all.push_back(
        {std::uint32_t(chains.points.size()), 0, std::uint32_t(ring.size()), true, false, {}, false});
  }

  static void add_chain(std::span<const geometry::Point> ring, const Look& from, const Look& to,
                        geometry::BoundaryChains& chains) {
    std::vector<geometry::Vec>& points = chains.points;
    const std::size_t n = ring.size(), begin = points.size();
    const auto add = [&](geometry::Vec p) {
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
    chains.all.push_back({std::uint32_t(points.size()),
                          first,
                          std::max(last, std::min(first + 1, behind)),
                          false,
                          false,
                          {},
                          false});
  }

  NextLevel& next_;
  double limit_ = 0;
  bool fresh_ = false;  // whether the last point was served
  std::vector<Look> looks_;
};

// A clearance field with one known nearest point of the next level.
class SinglePointField : public ClearanceField {
 public:
  SinglePointField(geometry::Vec at, double reach) : at_(at), reach_(reach) {}
  double clearance(geometry::Vec place, double limit) override {
    return std::min(limit, length(place - at_) - reach_);
  }

 private:
  geometry::Vec at_;
  double reach_;
};

// Simplifies the points from `begin` to `last` by the algorithm of Douglas and Peucker; appends all kept ones
// but the last.
void simplify(std::span<const MedialPoint> places, std::size_t begin, std::size_t last, double tolerance,
              std::vector<geometry::Point>& out) {
  double worst = tolerance * tolerance;
  std::size_t at = begin;
  for (std::size_t i = begin + 1; i < last; ++i) {
    const double d = square_distance(places[i].at, places[begin].at, places[last].at);
    if (d > worst) {
      worst = d;
      at = i;
    }
  }
  if (at == begin) {
    out.push_back(to_point(places[begin].at));
    return;
  }
  simplify(places, begin, at, tolerance, out);
  simplify(places, at, last, tolerance, out);
}

void add_branch(std::span<const MedialPoint> branch, double tolerance, std::vector<geometry::Point>& line,
                ExtrusionLines& extrusions) {
  for (std::size_t begin = 0; begin + 1 < branch.size();) {
    double low = branch[begin].radius, high = low, way = 0;
    std::size_t last = begin;
    while (last + 1 < branch.size()) {
      const double radius = branch[last + 1].radius, l = std::min(low, radius), h = std::max(high, radius);
      if (h > kTaper * l && way > high) break;
      way += length(branch[last + 1].at - branch[last].at);
      low = l;
      high = h;
      ++last;
    }
    line.clear();
    simplify(branch, begin, last, tolerance, line);
    line.push_back(to_point(branch[last].at));
    line.erase(std::unique(line.begin(), line.end()), line.end());
    if (line.size() > 1) {
      extrusions.lines.add(line);
      extrusions.widths.push_back(std::int32_t(std::ceil(2 * high)));
    }
    begin = last;
  }
}

}  // namespace

class GapFiller::Work {
 public:
  void find(const geometry::Rings& outer, const geometry::Rings& next, const GapBand& band,
            double narrowest_mm, double tolerance_mm, ExtrusionLines& extrusions) {
    const GapLimits limits = gap_limits(band, narrowest_mm, tolerance_mm);
    next_.take(next, limits.axis.next - limits.axis.covered);
    chains_.clear();
    for (std::size_t r = 0; r < outer.size(); ++r)
      if (outer[r].size() > 2 &&
          !(too_small(outer[r], limits.axis.covered + limits.axis.narrowest) && twice_area(outer[r]) > 0))
        scan_.add(outer[r], limits.near, chains_);
    lay(chains_, limits, tolerance_mm, extrusions);
  }

  void find(geometry::BoundaryChains& chains, const geometry::Rings& next, const GapBand& band,
            double narrowest_mm, double tolerance_mm, ExtrusionLines& extrusions) {
    if (chains.empty()) return;
    const GapLimits limits = gap_limits(band, narrowest_mm, tolerance_mm);
    next_.take(next, limits.axis.next - limits.axis.covered);
    lay(chains, limits, tolerance_mm, extrusions);
  }

 private:
  void lay(geometry::BoundaryChains& chains, const GapLimits& limits, double tolerance_mm,
           ExtrusionLines& extrusions) {
    const double branch_tolerance = 0.5 * std::max(100.0, tolerance_mm * geometry::kUnitsPerMm);
    sampler_.begin(limits.near, limits.void_at, limits.enough, limits.axis.inside > 0);
    const std::span<geometry::BoundaryChains::Chain> all = chains.all;
    const auto add_lines = [&](ClearanceField& field) {
      if (sampler_.samples.empty()) return;
      for (const std::vector<MedialPoint>& branch :
           medial_axis_(sampler_.segments, sampler_.samples, limits.axis, field))
        add_branch(branch, branch_tolerance, line_, extrusions);
    };
    for (std::size_t i = 0, end; i < all.size(); i = end) {
      bool open = false;
      for (end = i; end < all.size() && (end == i || !all[end].leads); ++end) {
        geometry::BoundaryChains::Chain& chain = all[end];
        if (chain.cornered && chains.cusps_moved) chain.cornered = next_.snap(chain.ahead, kMoved);
        open = open || !chain.cornered;
        if (!chain.cornered) continue;
        sampler_.clear();
        sampler_.add(points_of(chains, end), chain);
        SinglePointField corner(chain.ahead, limits.axis.next - limits.axis.covered);
        add_lines(corner);
      }
      if (!open) continue;
      sampler_.clear();
      for (std::size_t k = i; k < end; ++k) {
        if (all[k].cornered)
          sampler_.add_segments(points_of(chains, k), all[k]);
        else
          sampler_.add(points_of(chains, k), all[k]);
      }
      add_lines(next_);
    }
  }

  static std::span<const geometry::Vec> points_of(const geometry::BoundaryChains& chains, std::size_t i) {
    const std::size_t begin = i ? chains.all[i - 1].end : 0;
    return std::span(chains.points).subspan(begin, chains.all[i].end - begin);
  }

  NextLevel next_;
  RingGapScan scan_{next_};
  BoundarySampler sampler_{next_};
  MedialAxis medial_axis_;
  geometry::BoundaryChains chains_;
  std::vector<geometry::Point> line_;
};

GapFiller::GapFiller() : work_(std::make_unique<Work>()) {}
GapFiller::~GapFiller() = default;

void GapFiller::operator()(const geometry::Rings& outer, const geometry::Rings& next, const GapBand& band,
                           double narrowest_mm, double tolerance_mm, bool touching,
                           ExtrusionLines& extrusions) {
  if (outer.empty() || narrowest_mm <= 0) return;
  work_->find(touching ? region_of(outer) : outer, next, band, narrowest_mm, tolerance_mm, extrusions);
}

void GapFiller::operator()(geometry::BoundaryChains& uncovered, const geometry::Rings& next,
                           const GapBand& band, double narrowest_mm, double tolerance_mm,
                           ExtrusionLines& extrusions) {
  work_->find(uncovered, next, band, narrowest_mm, tolerance_mm, extrusions);
}

}  // namespace firn::slice
