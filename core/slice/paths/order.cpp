#include "core/slice/paths/order.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/geometry/box.h"
#include "core/geometry/point_measures.h"
#include "core/grid/random.h"

namespace firn::slice {
namespace {

constexpr std::size_t kWindow = 400;
constexpr std::uint32_t kBlock = 16;  // points of a ring per box

double square_distance(const BoxOf<std::int32_t>& box, Point p) {
  const double x = std::max({0.0, double(box.x0) - p.x, double(p.x) - box.x1});
  const double y = std::max({0.0, double(box.y0) - p.y, double(p.y) - box.y1});
  return x * x + y * y;
}

struct Stop {
  std::uint32_t line = 0;
  std::uint32_t first = 0;  // closed: point where it begins
  bool reversed = false;    // open lines
  Point entry, exit;
};

std::uint32_t fixed_seam(std::span<const Point> ring, const PathOptions& options, std::int32_t layer,
                         std::uint32_t number) {
  if (options.seam == SeamPlacement::kRandom) {
    const DrawKey key{options.seed, Purpose::kSeam, std::uint32_t(layer), 0, number};
    return random_below(key, std::uint32_t(ring.size()));
  }
  const auto lowest = std::min_element(ring.begin(), ring.end(),
                                       [](Point a, Point b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
  return std::uint32_t(lowest - ring.begin());
}

// Orders closed lines, which begin at any of their points or at a fixed seam. Rings are removed one by one,
// which a static R-tree does not support: a list of boxes prunes the scan.
std::vector<Stop> nearest_rings(const Rings& lines, const PathOptions& options, std::int32_t layer,
                                std::uint32_t number, Point at) {
  struct Candidate {
    std::uint32_t line;
    BoxOf<std::int32_t> box;
    std::uint32_t blocks;  // index of the first box of its points
  };
  const std::uint32_t n = std::uint32_t(lines.size());
  std::vector<Candidate> left(n);
  std::vector<std::uint32_t> seams;
  std::vector<BoxOf<std::int32_t>> blocks;
  for (std::uint32_t i = 0; i < n; ++i) {
    left[i] = {i, {}, std::uint32_t(blocks.size())};
    const std::span<const Point> line = lines[i];
    for (std::size_t p = 0; p < line.size(); p += kBlock) {
      BoxOf<std::int32_t>& box = blocks.emplace_back();
      for (const Point q : line.subspan(p, std::min<std::size_t>(kBlock, line.size() - p))) box.add(q.x, q.y);
      left[i].box.add(box);
    }
  }
  const bool seam_fixed = options.seam != SeamPlacement::kNearest;
  if (seam_fixed)
    for (std::uint32_t i = 0; i < n; ++i) seams.push_back(fixed_seam(lines[i], options, layer, number + i));
  std::vector<Stop> stops;
  stops.reserve(n);
  std::size_t chosen = 0;
  while (!left.empty()) {
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t first = 0;
    const std::size_t begin = chosen;  // neighbours in the list are usually adjacent
    for (std::size_t tried = 0; tried < left.size(); ++tried) {
      const std::size_t k = begin + tried < left.size() ? begin + tried : begin + tried - left.size();
      const Candidate& c = left[k];
      if (square_distance(c.box, at) >= best) continue;
      const auto line = lines[c.line];
      const auto offer = [&](std::uint32_t p) {
        const double d = square_distance(line[p], at);
        if (d < best) {
          best = d;
          chosen = k;
          first = p;
        }
      };
      if (seam_fixed) {
        offer(seams[c.line]);
        continue;
      }
      for (std::uint32_t p = 0, block = c.blocks; p < line.size(); p += kBlock, ++block) {
        if (square_distance(blocks[block], at) >= best) continue;
        for (std::uint32_t q = p; q < std::min<std::size_t>(p + kBlock, line.size()); ++q) offer(q);
      }
    }
    at = lines[left[chosen].line][first];
    stops.push_back({left[chosen].line, first, false, at, at});
    left.erase(left.begin() + std::ptrdiff_t(chosen));
    if (chosen == left.size()) chosen = 0;
  }
  return stops;
}

// Orders open lines, which begin at either end.
std::vector<Stop> nearest_ends(const Rings& lines, Point at) {
  std::vector<double> x, y;  // of the remaining lines: front, back, front...
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < lines.size(); ++i) {
    for (const Point p : {lines[i].front(), lines[i].back()}) {
      x.push_back(p.x);
      y.push_back(p.y);
    }
    left.push_back(i);
  }
  std::vector<double> squares(x.size());
  std::vector<Stop> stops;
  stops.reserve(left.size());
  for (std::size_t end = 0; !left.empty();) {
    const double from_x = at.x, from_y = at.y;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Lanes2 best = {kNone, kNone};
    for (std::size_t k = 0; k < x.size(); k += 2) {
      const Lanes2 dx = Lanes2{x[k], x[k + 1]} - from_x, dy = Lanes2{y[k], y[k + 1]} - from_y;
      const Lanes2 square = dx * dx + dy * dy;
      std::memcpy(&squares[k], &square, sizeof square);
      best = square < best ? square : best;
    }
    // Takes the first one at the minimum distance, from the position of the last one: neighbours in the list
    // are usually adjacent.
    const double least = std::min(best[0], best[1]);
    while (squares[end] != least) end = end + 1 < x.size() ? end + 1 : 0;
    const std::size_t chosen = end / 2;
    const auto line = lines[left[chosen]];
    const bool reversed = end % 2 == 1;
    stops.push_back({left[chosen], 0, reversed, reversed ? line.back() : line.front(),
                     reversed ? line.front() : line.back()});
    at = stops.back().exit;
    for (std::vector<double>* v : {&x, &y})
      v->erase(v->begin() + std::ptrdiff_t(2 * chosen), v->begin() + std::ptrdiff_t(2 * chosen + 2));
    left.erase(left.begin() + std::ptrdiff_t(chosen));
    end = chosen < left.size() ? 2 * chosen : 0;
  }
  return stops;
}

// Reverses parts of the order while that shortens the travel.
void two_opt(std::vector<Stop>& stops, Point at, int passes) {
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
  const auto may_win = [&](Point before, double there, std::size_t j) {
    constexpr float kSlack = 8.0f, kMore = 1.0f + 1e-5f;
    Four x, y, most;
    std::memcpy(&x, &exit_x[j], sizeof x);
    std::memcpy(&y, &exit_y[j], sizeof y);
    std::memcpy(&most, &ways[j], sizeof most);
    x -= float(before.x);
    y -= float(before.y);
    most = (most + (float(there) + kSlack)) * kMore;
    return signs(x * x + y * y < most * most) != 0;
  };
  for (std::size_t k = 0; k < n; ++k) measure(k);
  for (int pass = 0; pass < passes; ++pass) {
    bool better = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const Point before = i ? stops[i - 1].exit : at;
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

void append_in_order(const Rings& lines, const PathInfo& info, const PathOptions& options, Point& at,
                     LayerPaths& paths, std::span<const std::int32_t> widths) {
  std::vector<Stop> stops =
      info.closed ? nearest_rings(lines, options, paths.layer, std::uint32_t(paths.info.size()), at)
                  : nearest_ends(lines, at);
  two_opt(stops, at, options.two_opt_passes);
  for (const Stop& stop : stops) {
    const auto line = lines[stop.line];
    std::vector<Point>& out = paths.lines.points;
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
