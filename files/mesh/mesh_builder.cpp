#include "files/mesh/mesh_builder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "files/mesh/cut_polygon.h"

namespace firn::mesh {
namespace {

// A float below 64 steps by at most 4e-6: of millimetres, a hundredth of what the slicer's grid resolves.
constexpr double kFar = 64.0;
constexpr std::size_t kMaxTests = 500'000'000;  // some seconds, for all polygons of a file

}  // namespace

void NearOrigin::choose(const std::array<double, 3>& p) {
  is_first_ = false;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::isfinite(p[axis]) && std::abs(p[axis]) >= kFar) at_[axis] = p[axis];
}

void MeshBuilder::leave_out(std::size_t place) {
  if (degenerate_++ == 0) first_degenerate_ = place;
}

void MeshBuilder::add_facet(std::span<const std::uint32_t> corners, std::size_t place) {
  if (corners.size() == 3) {
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
      return leave_out(place);
    data_.triangles.push_back({corners[0], corners[1], corners[2]});
    return;
  }
  if (corners.size() < 3) {
    ++thin_;
    return;
  }
  distinct_.assign(corners.begin(), corners.end());
  distinct_.erase(std::unique(distinct_.begin(), distinct_.end()), distinct_.end());
  while (distinct_.size() > 1 && distinct_.back() == distinct_.front()) distinct_.pop_back();
  if (distinct_.size() < 3) return leave_out(place);
  if (distinct_.size() > 3) polygons_.push_back({data_.triangles.size(), std::uint32_t(distinct_.size())});
  for (std::size_t c = 2; c < distinct_.size(); ++c)
    data_.triangles.push_back({distinct_[0], distinct_[c - 1], distinct_[c]});
}

MeshData MeshBuilder::finish(const std::function<std::string(std::size_t)>& place_text) {
  std::size_t tests = kMaxTests, fans = 0;
  for (const Polygon& p : polygons_) {
    const std::span<Triangle> fan = std::span(data_.triangles).subspan(p.first, p.corners - 2);
    distinct_.assign({fan[0][0], fan[0][1]});
    for (const Triangle& t : fan) distinct_.push_back(t[2]);
    if (!is_convex(distinct_, data_.vertices)) fans += !cut_polygon(distinct_, data_.vertices, tests, fan);
  }
  if (fans)
    data_.defects.push_back(
        fmt::format("{} concave faces have too many corners to be cut into triangles: they are fans", fans));
  if (thin_) data_.defects.push_back(fmt::format("{} faces have fewer than 3 corners", thin_));
  if (degenerate_)
    data_.defects.push_back(
        fmt::format("{} facets name a vertex twice and were left out, the first one at {}", degenerate_,
                    place_text(first_degenerate_)));
  data_.origin = near_.at();
  return std::move(data_);
}

}  // namespace firn::mesh
