#include <algorithm>

#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

// Corners of a loop, with the middles of its arcs: enough to tell its direction and what lies in it.
std::vector<Vec> corners_of(std::span<const Source> sources, std::span<const Piece> pieces, double d) {
  std::vector<Vec> corners;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    corners.push_back(pieces[i].from);
    const Source& source = sources[pieces[i].source];
    if (source.corner()) corners.push_back(middle(source, pieces[i].from, pieces[i + 1 < pieces.size() ? i + 1 : 0].from, d));
  }
  return corners;
}

double area(std::span<const Vec> corners) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) sum += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return sum;
}

bool inside(std::span<const Vec> corners, Vec p) {
  bool in = false;
  Vec a = corners.back();
  for (const Vec b : corners) {
    if ((a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x) in = !in;
    a = b;
  }
  return in;
}

}  // namespace

Vec middle(const Source& source, Vec a, Vec b, double d) {
  if (!source.corner()) return 0.5 * (a + b);
  const Vec sum = (a - source.at) + (b - source.at);
  const double l = length(sum);
  return l > 0 ? source.at + (d / l) * sum : a;
}

void regroup(std::span<const Source> sources, const Component& loops, double d, Components& out) {
  struct Loop {
    std::span<const Piece> pieces;
    std::vector<Vec> corners;
    double area = 0;
    std::vector<std::size_t> holes;
  };
  std::vector<Loop> list(loops.ends.size());
  std::vector<std::size_t> outers;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::size_t begin = i ? loops.ends[i - 1] : 0;
    list[i].pieces = std::span(loops.pieces).subspan(begin, loops.ends[i] - begin);
    list[i].corners = corners_of(sources, list[i].pieces, d);
    list[i].area = area(list[i].corners);
    if (list[i].area > 0) outers.push_back(i);
  }
  std::stable_sort(outers.begin(), outers.end(), [&](std::size_t a, std::size_t b) { return list[a].area < list[b].area; });
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].area > 0) continue;
    for (const std::size_t outer : outers) {
      if (outers.size() > 1 && !inside(list[outer].corners, list[i].corners[0])) continue;
      list[outer].holes.push_back(i);
      break;
    }
  }
  for (const Loop& outer : list) {
    if (outer.area <= 0) continue;
    Component& component = out.add();
    const auto add = [&](const Loop& loop) {
      component.pieces.insert(component.pieces.end(), loop.pieces.begin(), loop.pieces.end());
      component.ends.push_back(std::uint32_t(component.pieces.size()));
    };
    add(outer);
    for (const std::size_t hole : outer.holes) add(list[hole]);
  }
}

}  // namespace firn::slice::wavefront
