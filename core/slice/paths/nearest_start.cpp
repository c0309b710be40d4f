#include "core/slice/paths/nearest_start.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/geometry/point_measures.h"

namespace firn::slice {
namespace {

constexpr std::uint32_t kBlock = 16;  // points

// The bits of a number, each followed by a zero.
std::uint64_t spread(std::uint32_t number) {
  std::uint64_t bits = number;
  bits = (bits | bits << 16) & 0x0000ffff0000ffffull;
  bits = (bits | bits << 8) & 0x00ff00ff00ff00ffull;
  bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0full;
  bits = (bits | bits << 2) & 0x3333333333333333ull;
  return (bits | bits << 1) & 0x5555555555555555ull;
}

std::uint64_t morton_code(geometry::Point p) {
  constexpr std::uint32_t kSign = 1u << 31;  // negative numbers come first
  return spread(std::uint32_t(p.x) ^ kSign) | spread(std::uint32_t(p.y) ^ kSign) << 1;
}

}  // namespace

void NearestStart::add_all(const geometry::Rings& lines, std::uint32_t line, double reach,
                           std::vector<Starts>& starts) {
  const auto points = lines[line];
  geometry::BoxOf<std::int32_t> box;
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    box.add(points[p].x, points[p].y);
    if (p == 0 || p - starts.back().first == kBlock || double(box.x1) - box.x0 > reach ||
        double(box.y1) - box.y0 > reach) {
      starts.push_back({line, p, p});
      box = {points[p].x, points[p].y, points[p].x, points[p].y};
    }
    starts.back().behind = p + 1;
  }
}

NearestStart::NearestStart(const geometry::Rings& lines, std::span<const Starts> starts)
    : lines_(lines), leaf_of_(starts.size()), left_(lines.size()) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(starts.size());
  for (std::uint32_t s = 0; s < starts.size(); ++s) {
    if (s == 0 || starts[s].line != starts[s - 1].line) first_of_.push_back(s);
    order.push_back({morton_code(lines[starts[s].line][starts[s].first]), s});
  }
  first_of_.push_back(std::uint32_t(starts.size()));
  std::sort(order.begin(), order.end());
  tree_.resize(starts.size());
  leaves_.reserve(starts.size());
  for (const auto& [code, s] : order) {
    const Starts& points = starts[s];
    leaf_of_[s] = std::uint32_t(leaves_.size());
    tree_.set(leaves_.size(), box_of(lines[points.line].subspan(points.first, points.behind - points.first)));
    leaves_.push_back(points);
  }
  tree_.build();
}

NearestStart::Place NearestStart::take(geometry::Point at) {
  double best = std::numeric_limits<double>::max();
  Place place{};
  std::uint32_t behind_last = 0;  // how far the line comes behind the last one
  tree_.nearest(at.x, at.y, [&](std::size_t leaf) {
    const Starts& points = leaves_[leaf];
    const auto line = lines_[points.line];
    const std::uint32_t behind =
        points.line - next_ + (points.line < next_ ? std::uint32_t(lines_.size()) : 0);
    for (std::uint32_t p = points.first; p < points.behind; ++p) {
      const double square = square_distance(line[p], at);
      if (square > best || (square == best && std::pair(behind, p) >= std::pair(behind_last, place.point)))
        continue;
      best = square;
      behind_last = behind;
      place = {points.line, p};
    }
    looked_at_ += points.behind - points.first;
    return best;
  });
  for (std::uint32_t s = first_of_[place.line]; s < first_of_[place.line + 1]; ++s) tree_.remove(leaf_of_[s]);
  --left_;
  next_ = place.line + 1;
  return place;
}

}  // namespace firn::slice
