#include "core/slice/order.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/grid/random.h"
#include "core/slice/box_pairs.h"

namespace firn::slice {
namespace {

constexpr std::size_t kWindow = 400;
constexpr std::uint32_t kBlock = 16;  // points of a ring that one box stands for

double square_distance(Point a, Point b) {
  const double x = double(a.x) - b.x, y = double(a.y) - b.y;
  return x * x + y * y;
}

double distance(Point a, Point b) { return std::sqrt(square_distance(a, b)); }

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
  const auto lowest = std::min_element(ring.begin(), ring.end(), [](Point a, Point b) {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  return std::uint32_t(lowest - ring.begin());
}

std::vector<Stop> nearest_neighbour(const Rings& lines, bool closed, const PathOptions& options, std::int32_t layer,
                                    std::uint32_t number, Point at) {
  struct Candidate {
    std::uint32_t line;
    BoxOf<std::int32_t> box;  // of a ring
    std::uint32_t blocks;     // of its points: the first one's box
    Point front, back;        // of an open line
  };
  const std::uint32_t n = std::uint32_t(lines.size());
  std::vector<Candidate> left(n);
  std::vector<std::uint32_t> seams;
  std::vector<BoxOf<std::int32_t>> blocks;
  for (std::uint32_t i = 0; i < n; ++i) {
    left[i] = {i, {}, std::uint32_t(blocks.size()), lines[i].front(), lines[i].back()};
    if (!closed) continue;
    const std::span<const Point> line = lines[i];
    for (std::size_t p = 0; p < line.size(); p += kBlock) {
      BoxOf<std::int32_t>& box = blocks.emplace_back();
      for (const Point q : line.subspan(p, std::min<std::size_t>(kBlock, line.size() - p))) box.add(q.x, q.y);
      left[i].box.add(box);
    }
  }
  const bool seam_fixed = closed && options.seam != SeamPlacement::kNearest;
  if (seam_fixed)
    for (std::uint32_t i = 0; i < n; ++i) seams.push_back(fixed_seam(lines[i], options, layer, number + i));
  std::vector<Stop> stops;
  stops.reserve(n);
  std::size_t chosen = 0;
  while (!left.empty()) {
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t first = 0;
    bool reversed = false;
    const auto offer = [&](Point p, std::size_t k, std::uint32_t begin, bool backward) {
      const double d = square_distance(p, at);
      if (d < best) best = d, chosen = k, first = begin, reversed = backward;
    };
    const std::size_t begin = chosen;  // neighbours in the list mostly lie side by side
    for (std::size_t tried = 0; tried < left.size(); ++tried) {
      const std::size_t k = begin + tried < left.size() ? begin + tried : begin + tried - left.size();
      const Candidate& c = left[k];
      if (!closed) {
        offer(c.front, k, 0, false);
        offer(c.back, k, 0, true);
      } else if (square_distance(c.box, at) < best) {
        const auto line = lines[c.line];
        if (seam_fixed) {
          offer(line[seams[c.line]], k, seams[c.line], false);
        } else {
          for (std::uint32_t p = 0, block = c.blocks; p < line.size(); p += kBlock, ++block) {
            if (square_distance(blocks[block], at) >= best) continue;
            for (std::uint32_t q = p; q < std::min<std::size_t>(p + kBlock, line.size()); ++q) offer(line[q], k, q, false);
          }
        }
      }
    }
    const Candidate& c = left[chosen];
    const Point seam = lines[c.line][first];
    stops.push_back({c.line, first, reversed, closed ? seam : reversed ? c.back : c.front, closed ? seam : reversed ? c.front : c.back});
    at = stops.back().exit;
    left.erase(left.begin() + std::ptrdiff_t(chosen));
    if (chosen == left.size()) chosen = 0;
  }
  return stops;
}

// Reverses stretches of the order while that shortens the way.
void two_opt(std::vector<Stop>& stops, Point at, int passes) {
  using Pair = Lanes2;
  const std::size_t n = stops.size();
  std::vector<double> link(n + 1, 0.0);           // [k]: the way from stop k to the next
  std::vector<double> exit_x(n + 1), exit_y(n + 1);
  const auto measure = [&](std::size_t k) {
    if (k + 1 < n) link[k] = distance(stops[k].exit, stops[k + 1].entry);
    exit_x[k] = stops[k].exit.x, exit_y[k] = stops[k].exit.y;
  };
  // What is won by going from `before` to the exit of j is less than both ways that go. Of two stops: may either win?
  const auto may_win = [&](Point before, double there, std::size_t j) {
    Pair x, y, most;
    std::memcpy(&x, &exit_x[j], sizeof x);
    std::memcpy(&y, &exit_y[j], sizeof y);
    std::memcpy(&most, &link[j], sizeof most);
    x -= double(before.x), y -= double(before.y), most += there;
    return lanes_of(x * x + y * y < most * most) != 0;
  };
  for (std::size_t k = 0; k < n; ++k) measure(k);
  for (int pass = 0; pass < passes; ++pass) {
    bool better = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const Point before = i ? stops[i - 1].exit : at;
      double there = distance(before, stops[i].entry);
      for (std::size_t j = i + 1; j < std::min(n, i + kWindow); ++j) {
        if ((j - i) % 2 == 1 && !may_win(before, there, j)) {
          ++j;
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
      nearest_neighbour(lines, info.closed, options, paths.layer, std::uint32_t(paths.info.size()), at);
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
