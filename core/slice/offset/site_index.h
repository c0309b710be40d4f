// SiteIndex computes whether a site of the wavefront is nearer to a point than a distance.
#pragma once

#include <algorithm>
#include <span>

#include "core/geometry/rtree.h"
#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

inline double square_distance(geometry::Vec place, const Site& site) {
  geometry::Vec away = place - site.at;
  if (!site.corner()) away = away - std::clamp(dot(away, site.along), 0.0, site.length) * site.along;
  return dot(away, away);
}

/// The R-tree is built at the first query. Keeps its working memory.
class SiteIndex {
 public:
  void begin(std::span<const Site> sites) {
    sites_ = sites;
    built_ = false;
  }
  /// Returns whether any site is nearer to the point than `distance`.
  bool operator()(geometry::Vec place, double distance) {
    if (!built_) build();
    const double square = distance * distance;
    return tree_.any_nearer(place.x, place.y, distance,
                            [&](std::size_t block) { return near(block, place, square); });
  }

 private:
  static constexpr std::size_t kBlock = 16;  // sites per leaf: a tree with few queries must be cheap to build

  std::span<const Site> block_of(std::size_t block) const {
    const std::size_t first = block * kBlock;
    return sites_.subspan(first, std::min(kBlock, sites_.size() - first));
  }
  void build() {
    tree_.resize((sites_.size() + kBlock - 1) / kBlock);
    for (std::size_t block = 0; block * kBlock < sites_.size(); ++block) {
      geometry::BoxOf<double> box;
      for (const Site& s : block_of(block)) {
        const geometry::Vec end = s.at + std::max(s.length, 0.0) * s.along;  // a corner's length is below 0
        box.add(s.at.x, s.at.y);
        box.add(end.x, end.y);
      }
      tree_.set(block, geometry::floor_of(box.x0), geometry::floor_of(box.y0), geometry::floor_of(box.x1) + 1,
                geometry::floor_of(box.y1) + 1);
    }
    tree_.build();
    built_ = true;
  }
  bool near(std::size_t block, geometry::Vec place, double square) const {
    const std::span<const Site> sites = block_of(block);
    return std::any_of(sites.begin(), sites.end(),
                       [&](const Site& s) { return wavefront::square_distance(place, s) < square; });
  }

  std::span<const Site> sites_;
  geometry::StaticRTree tree_;
  bool built_ = false;
};

}  // namespace firn::slice::wavefront
