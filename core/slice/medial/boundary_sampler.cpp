#include "core/slice/medial/boundary_sampler.h"

#include <algorithm>
#include <cmath>

namespace firn::slice {
namespace {

constexpr double kStep = 0.6 * geometry::kUnitsPerMm;   // maximum spacing
constexpr double kClose = 0.3 * geometry::kUnitsPerMm;  // minimum spacing
constexpr double kTip = 0.15 * geometry::kUnitsPerMm;   // from a cusp to the sample beside it
constexpr double kTipFacing = -0.174;  // cosine between the normals of the segments of a cusp

bool near(geometry::Vec a, geometry::Vec b) { return dot(a - b, a - b) < kClose * kClose; }

}  // namespace

void BoundarySampler::begin(double limit, double void_at, double enough, bool eroded_cores) {
  limit_ = limit;
  void_at_ = void_at;
  enough_ = enough;
  eroded_cores_ = eroded_cores;
  clear();
}

void BoundarySampler::clear() {
  run_ = 0;
  way_ = 0;
  segments.clear();
  samples.clear();
}

void BoundarySampler::add_segments(std::span<const geometry::Vec> points,
                                   const geometry::BoundaryChains::Chain& chain) {
  const std::size_t n = points.size();
  const std::size_t edges = chain.closed ? n : n - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    const geometry::Vec from = points[i], to = points[i + 1 < n ? i + 1 : 0], way = to - from;
    const bool sampled = chain.closed || (i >= chain.first && i < chain.last);
    const double l = length(way);
    segments.push_back({from, to, (1 / l) * left_of(way), way_, l, sampled});
    way_ += l;
  }
}

void BoundarySampler::add(std::span<const geometry::Vec> points,
                          const geometry::BoundaryChains::Chain& chain) {
  const std::size_t n = points.size();
  first_segment_ = segments.size();
  chain_ = &chain;
  begun_ = false;
  add_segments(points, chain);
  if (chain.closed) {
    for (std::size_t i = 0; i < n; ++i) {
      sample_corner(i, i ? i - 1 : n - 1);
      sample_edge(i);
    }
  } else {
    for (std::size_t i = chain.first; i < chain.last; ++i) {
      if (i > chain.first) sample_corner(i, i - 1);
      sample_edge(i);
    }
  }
  ++run_;
}

// Returns whether the next level is so near that the point is no centre of a void.
bool BoundarySampler::covered(geometry::Vec void_disc) {
  if (enough_ <= 0) return false;
  if (!chain_->cornered) return !next_.empty() && next_.within(void_disc, enough_);
  const geometry::Vec off = void_disc - chain_->ahead;
  return dot(off, off) <= enough_ * enough_;
}

void BoundarySampler::add_sample(geometry::Vec at, geometry::Vec normal, double order) {
  const geometry::Vec tip = at + limit_ * normal;
  if (begun_ && near(at, last_at_) && near(tip, last_tip_)) return;
  if (covered(at + void_at_ * normal)) return;
  samples.push_back({at, normal, order, run_});
  begun_ = true;
  last_at_ = at;
  last_tip_ = tip;
}

// Places one sample in the middle of an edge, and as many more to both sides as its length requires.
void BoundarySampler::sample_edge(std::size_t edge) {
  const std::size_t segment = first_segment_ + edge;
  const BoundarySegment& w = segments[segment];
  if (w.length <= kClose) return;
  const geometry::Vec way = w.to - w.from;
  const int looks = 2 * int(0.5 * w.length / kStep) + 1;
  for (int k = 0; k < looks; ++k) {
    const double share = (k + 0.5) / looks;
    add_sample(w.from + share * way, w.normal, w.begin + share * w.length);
  }
}

// A smooth corner is sampled between the normals of its segments; a reflex one in all directions between
// them.
void BoundarySampler::sample_corner(std::size_t edge, std::size_t before) {
  const std::size_t segment = first_segment_ + edge;
  const geometry::Vec at = segments[segment].from, from = segments[first_segment_ + before].normal,
                      to = segments[segment].normal;
  const bool reflex = cross(from, to) < 0, back = dot(from, to) < -0.9;
  if (!reflex && dot(from, to) < 0.5) {
    if (!eroded_cores_ || dot(from, to) > kTipFacing) return;
    const BoundarySegment& w = segments[segment];
    const double share = std::min(0.25, kTip / w.length);
    add_sample(at + share * (w.to - at), to, w.begin + share * w.length);
    return;
  }
  const int steps = reflex ? std::max(2, int(std::ceil(length(to - from) * limit_ / kStep))) : 2;
  for (int k = 1; k < steps; ++k) {
    const double share = double(k) / steps;
    // Passes through the middle direction, where the sum would vanish.
    const geometry::Vec turned = back ? 2 * std::min(share, 1 - share) * left_of(to - from) : geometry::Vec{};
    const geometry::Vec normal = (1 - share) * from + share * to + turned;
    const double l = length(normal);
    if (l > 0) add_sample(at, (1 / l) * normal, segments[segment].begin);
  }
}

}  // namespace firn::slice
