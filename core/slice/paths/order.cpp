#include "core/slice/paths/order.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/geometry/point_measures.h"
#include "core/grid/random.h"
#include "core/slice/paths/nearest_start.h"

namespace firn::slice {
namespace {

constexpr std::size_t kWindow = 400;
constexpr double kReach = 8;  // of a block of start points, in widths

struct Stop {
  std::uint32_t line = 0;
  std::uint32_t first = 0;  // closed: point where it begins
  bool reversed = false;    // open lines
  geometry::Point entry, exit;
};

std::uint32_t fixed_seam(std::span<const geometry::Point> ring, const PathOptions& options,
                         std::int32_t layer, std::uint32_t number) {
  if (options.seam == SeamPlacement::kRandom) {
    const DrawKey key{options.seed, Purpose::kSeam, std::uint32_t(layer), 0, number};
    return random_below(key, std::uint32_t(ring.size()));
  }
  const auto lowest = std::min_element(ring.begin(), ring.end(), [](geometry::Point a, geometry::Point b) {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  return std::uint32_t(lowest - ring.begin());
}

// Returns where each line may begin: closed ones at any of their points or at a fixed seam, open ones at
// either end.
std::vector<NearestStart::Starts> starts_of(const geometry::Rings& lines, const PathInfo& info,
                                            const PathOptions& options, std::int32_t layer,
                                            std::uint32_t number) {
  std::vector<NearestStart::Starts> starts;
  for (std::uint32_t i = 0; i < lines.size(); ++i) {
    const std::uint32_t size = std::uint32_t(lines[i].size());
    if (!info.closed) {
      starts.push_back({i, 0, 1});
      starts.push_back({i, size - 1, size});
    } else if (options.seam != SeamPlacement::kNearest) {
      const std::uint32_t seam = fixed_seam(lines[i], options, layer, number + i);
      starts.push_back({i, seam, seam + 1});
    } else {
      NearestStart::add_all(lines, i, kReach * info.width, starts);
    }
  }
  return starts;
}

// Orders lines, each the nearest to the end of the one before.
std::vector<Stop> nearest_next(const geometry::Rings& lines, bool closed,
                               std::span<const NearestStart::Starts> starts, geometry::Point at) {
  NearestStart nearest(lines, starts);
  std::vector<Stop> stops;
  stops.reserve(lines.size());
  while (!nearest.empty()) {
    const auto [line, point] = nearest.take(at);
    const geometry::Point entry = lines[line][point];
    const bool reversed = !closed && point > 0;
    at = closed ? entry : reversed ? lines[line].front() : lines[line].back();
    stops.push_back({line, closed ? point : 0, reversed, entry, at});
  }
  return stops;
}

// Reverses parts of the order while that shortens the travel.
void two_opt(std::vector<Stop>& stops, geometry::Point at, int passes) {
  constexpr std::size_t kAtOnce = 4;
  using Four = float __attribute__((vector_size(16)));
  const std::size_t n = stops.size();
  std::vector<double> link(n, 0.0);  // [k]: distance from stop k to the next
  // Distances and exits in single precision: exact to one unit and 1e-6 of the value.
  std::vector<float> ways(n + kAtOnce), exit_x(n + kAtOnce), exit_y(n + kAtOnce);
  const auto measure = [&](std::size_t k) {
    if (k + 1 < n) link[k] = distance(stops[k].exit, stops[k + 1].entry);
    ways[k] = float(link[k]);
    exit_x[k] = float(stops[k].exit.x);
    exit_y[k] = float(stops[k].exit.y);
  };
  // The gain of going from `before` to the exit of j is less than the two distances that vanish. Returns
  // whether any of some stops may gain.
  const auto may_win = [&](geometry::Point before, double there, std::size_t j) {
    constexpr float kSlack = 8.0f, kMore = 1.0f + 1e-5f;
    Four x, y, most;
    std::memcpy(&x, &exit_x[j], sizeof x);
    std::memcpy(&y, &exit_y[j], sizeof y);
    std::memcpy(&most, &ways[j], sizeof most);
    x -= float(before.x);
    y -= float(before.y);
    most = (most + (float(there) + kSlack)) * kMore;
    return geometry::signs(x * x + y * y < most * most) != 0;
  };
  for (std::size_t k = 0; k < n; ++k) measure(k);
  for (int pass = 0; pass < passes; ++pass) {
    bool better = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const geometry::Point before = i ? stops[i - 1].exit : at;
      double there = distance(before, stops[i].entry);
      for (std::size_t j = i + 1; j < std::min(n, i + kWindow); ++j) {
        if ((j - i) % kAtOnce == 1 && !may_win(before, there, j)) {
          j += kAtOnce - 1;
          continue;
        }
        const double most = there + link[j], square = square_distance(before, stops[j].exit);
        if (square >= most * most) continue;
        double change = std::sqrt(square) - there;
        if (j + 1 < n) change += distance(stops[i].entry, stops[j + 1].entry) - link[j];
        if (change >= -1.0) continue;
        std::reverse(stops.begin() + std::ptrdiff_t(i), stops.begin() + std::ptrdiff_t(j) + 1);
        for (std::size_t k = i; k <= j; ++k) {
          stops[k].reversed = !stops[k].reversed;
          std::swap(stops[k].entry, stops[k].exit);
        }
        for (std::size_t k = i ? i - 1 : 0; k <= j; ++k) measure(k);
        there = distance(before, stops[i].entry);
        better = true;
      }
    }
    if (!better) break;
  }
}

}  // namespace

void append_in_order(const geometry::Rings& lines, const PathInfo& info, const PathOptions& options,
                     geometry::Point& at, LayerPaths& paths, std::span<const std::int32_t> widths) {
  std::vector<Stop> stops = nearest_next(
      lines, info.closed, starts_of(lines, info, options, paths.layer, std::uint32_t(paths.info.size())), at);
  two_opt(stops, at, options.two_opt_passes);
  for (const Stop& stop : stops) {
    const auto line = lines[stop.line];
    std::vector<geometry::Point>& out = paths.lines.points;
    if (info.closed) {
      out.insert(out.end(), line.begin() + stop.first, line.end());
      out.insert(out.end(), line.begin(), line.begin() + stop.first);
    } else if (stop.reversed) {
      out.insert(out.end(), line.rbegin(), line.rend());
    } else {
      out.insert(out.end(), line.begin(), line.end());
    }
    paths.lines.ends.push_back(std::uint32_t(out.size()));
    paths.info.push_back(info);
    if (!widths.empty()) paths.info.back().width = widths[stop.line];
    at = stop.exit;
  }
}

}  // namespace firn::slice
