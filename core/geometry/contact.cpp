#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/geometry/exact.h"
#include "core/geometry/planar.h"
#include "core/geometry/rtree.h"

namespace firn::geometry {
namespace {

// Neighbours share their corner. They have more in common only where the ring folds back on itself.
bool folds(const Edge& e, const Edge& following) {
  if (orientation(e.a, e.b, following.b) != 0) return false;
  const double forward = (double(e.b.x) - e.a.x) * (double(following.b.x) - following.a.x) +
                         (double(e.b.y) - e.a.y) * (double(following.b.y) - following.a.y);
  return !(forward > 0.0);  // collinear, so far from 0 unless an edge has no length
}

Point place_of(const Edge& e, const Edge& f) {
  for (const Point& p : {f.a, f.b})
    if (touch(e, {p, p})) return p;
  return touch(f, {e.a, e.a}) ? e.a : e.b;
}

// A raster over the edges of about four cells per edge. Of several contacts the one in its lowest row, and
// there in its leftmost cell, is reported.
class Raster {
 public:
  explicit Raster(std::span<const Edge> edges) {
    BoxOf<std::int32_t> box;
    for (const Edge& e : edges) box.add(box_of(e));
    low_x_ = box.x0;
    low_y_ = box.y0;
    const auto width = std::uint64_t(box.x1 - low_x_), height = std::uint64_t(box.y1 - low_y_);
    const std::uint64_t maximum = std::max<std::uint64_t>(16, 4 * edges.size());
    while (((width >> shift_) + 1) * ((height >> shift_) + 1) > maximum) ++shift_;
    across_ = std::int64_t(width >> shift_) + 1;
  }
  // Returns the first cell that both edges pass, row by row; kNone if there is no such cell.
  std::int64_t first_common_cell(const Edge& e, const Edge& f) const {
    const std::int64_t end = std::min(row(std::max(e.a.y, e.b.y)), row(std::max(f.a.y, f.b.y)));
    for (std::int64_t r = std::max(row(std::min(e.a.y, e.b.y)), row(std::min(f.a.y, f.b.y))); r <= end; ++r) {
      const auto [e_first, e_last] = columns(e, r);
      const auto [f_first, f_last] = columns(f, r);
      if (std::max(e_first, f_first) <= std::min(e_last, f_last))
        return r * across_ + std::max(e_first, f_first);
    }
    return kNone;
  }
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

 private:
  std::int64_t column(std::int64_t x) const { return (x - low_x_) >> shift_; }
  std::int64_t row(std::int64_t y) const { return (y - low_y_) >> shift_; }
  // The columns that an edge passes in a row, with room for rounding.
  std::pair<std::int64_t, std::int64_t> columns(const Edge& e, std::int64_t r) const {
    const std::int64_t left = std::min(e.a.x, e.b.x), right = std::max(e.a.x, e.b.x);
    const std::int64_t low = std::min(e.a.y, e.b.y), high = std::max(e.a.y, e.b.y);
    if (column(left) == column(right) || row(low) == row(high)) return {column(left), column(right)};
    constexpr double kRoom = 2.0;
    const double slope = (double(e.b.x) - e.a.x) / (double(e.b.y) - e.a.y);
    const double y0 = std::max(double(low_y_ + (r << shift_)) - kRoom, double(low));
    const double y1 = std::min(double(low_y_ + ((r + 1) << shift_)) + kRoom, double(high));
    const double x0 = e.a.x + (y0 - e.a.y) * slope, x1 = e.a.x + (y1 - e.a.y) * slope;
    return {column(std::max(left, std::int64_t(std::floor(std::min(x0, x1) - kRoom)))),
            column(std::min(right, std::int64_t(std::ceil(std::max(x0, x1) + kRoom))))};
  }

  std::int64_t low_x_ = 0, low_y_ = 0, across_ = 1;
  int shift_ = 0;
};

}  // namespace

std::optional<Contact> first_contact(const Rings& rings) {
  std::vector<Edge> edges;
  std::vector<std::uint32_t> next;
  edges.reserve(rings.points.size());
  next.reserve(rings.points.size());
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const std::span<const Point> ring = rings[r];
    if (ring.size() < 3) return Contact{r, r, ring.empty() ? Point{} : ring[0]};
    const std::size_t first = edges.size();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const bool last = i + 1 == ring.size();
      edges.push_back({ring[i], ring[last ? 0 : i + 1]});
      next.push_back(std::uint32_t(last ? first : edges.size()));
    }
  }
  const auto contact = [&](std::uint32_t i, std::uint32_t j) {
    const auto ring_of = [&](std::uint32_t e) {
      return std::size_t(std::upper_bound(rings.ends.begin(), rings.ends.end(), e) - rings.ends.begin());
    };
    return Contact{ring_of(i), ring_of(j), place_of(edges[i], edges[j])};
  };
  for (std::uint32_t i = 0; i < edges.size(); ++i)
    if (folds(edges[i], edges[next[i]])) return contact(i, next[i]);
  const Raster raster(edges);
  std::tuple first{Raster::kNone, std::size_t(0), std::size_t(0)};  // cell and edges
  tree_of(edges).pairs([&](std::size_t i, std::size_t j) {
    if (next[i] == j || next[j] == i || !touch(edges[i], edges[j])) return;
    first = std::min(first, std::tuple(raster.first_common_cell(edges[i], edges[j]), i, j));
  });
  const auto [cell, i, j] = first;
  if (cell != Raster::kNone) return contact(std::uint32_t(i), std::uint32_t(j));
  return std::nullopt;
}

}  // namespace firn::geometry
