#include "core/geometry/tolerant_boolean.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/geometry/planar.h"
#include "core/geometry/rtree.h"
#include "core/geometry/vec.h"

namespace firn::geometry {
namespace {

using Int = std::int64_t;
using Wide = __int128;

int sign(Wide v) { return (v > 0) - (v < 0); }

// An operand with the successors of its points; edge i connects point i and point next[i].
struct Outline {
  const Region& region;
  std::vector<std::uint32_t> next, ring;
  std::vector<BoxOf<std::int32_t>> boxes;  // of rings

  explicit Outline(const Region& r)
      : region(r), next(r.points.size()), ring(r.points.size()), boxes(r.size()) {
    std::size_t begin = 0;
    for (std::uint32_t k = 0; k < r.size(); ++k) {
      for (std::size_t i = begin; i < r.ends[k]; ++i) {
        next[i] = std::uint32_t(i + 1 < r.ends[k] ? i + 1 : begin);
        ring[i] = k;
        boxes[k].add(r.points[i].x, r.points[i].y);
      }
      begin = r.ends[k];
    }
  }
  Point at(std::size_t i) const { return region.points[i]; }
  BoxOf<std::int32_t> box(std::size_t i) const {
    BoxOf<std::int32_t> b;
    b.add(at(i).x, at(i).y);
    b.add(at(next[i]).x, at(next[i]).y);
    return b;
  }
};

Wide cross_product(Int ax, Int ay, Int bx, Int by) { return Wide(ax) * by - Wide(ay) * bx; }

// Returns the side of p + (e, e^2), e infinitesimal, of the line from a to b: never 0. `step` -1: of p - (e,
// e^2).
int side(Point a, Point b, Point p, int step) {
  const int s = sign(cross_product(Int(b.x) - a.x, Int(b.y) - a.y, Int(p.x) - a.x, Int(p.y) - a.y));
  if (s) return s;
  return step * (b.y != a.y ? (b.y > a.y ? -1 : 1) : (b.x > a.x ? 1 : -1));
}

// Returns the winding number of the rings of a region about p + step (e, e^2).
int winding_about(const Outline& o, Point p, int step) {
  int turns = 0;
  for (std::uint32_t k = 0; k < o.region.size(); ++k) {
    const auto& box = o.boxes[k];
    if (p.x < box.x0 || p.x > box.x1 || p.y < box.y0 || p.y > box.y1) continue;
    const auto ring = o.region[k];
    Point a = ring.back();
    for (const Point b : ring) {
      const bool a_below = step > 0 ? a.y <= p.y : a.y<p.y, b_below = step> 0 ? b.y <= p.y : b.y < p.y;
      if (a_below != b_below) {
        const int s = side(a, b, p, step);
        if (a_below)
          turns += s > 0;
        else
          turns -= s < 0;
      }
      a = b;
    }
  }
  return turns;
}

// Position of a crossing along an edge: (value + first e + second e^2) / scale, scale > 0.
struct Place {
  Wide value, first, second, scale;
  bool operator<(const Place& o) const {
    // Values are below 2^63 for coordinates within kMaxUnits: products fit.
    if (const int s = sign(value * o.scale - o.value * scale)) return s < 0;
    if (const int s = sign(first * o.scale - o.first * scale)) return s < 0;
    return second * o.scale < o.second * scale;
  }
};

Place place(Wide value, Wide first, Wide second, Wide scale) {
  return scale > 0 ? Place{value, first, second, scale} : Place{-value, -first, -second, -scale};
}

struct Crossing {
  std::uint32_t edge[2];  // above, layer
  Place place[2];
  Point at;
  bool leaves = false;  // the outline of the layer leaves `above` here
  bool active = true, visited = false;
  std::uint32_t following[2] = {0, 0};  // next crossing along each outline's ring
};

class TolerantUnion {
 public:
  TolerantUnion(const Region& above, const Region& layer, std::int32_t tolerance)
      : above_(above), layer_(layer), tolerance_(tolerance) {
    tree_.set_rings(above);
    tree_.build();
  }

  bool run(Region& merged) {
    find_crossings();
    for (int o = 0; o < 2; ++o) order_along(o);
    drop_slivers();
    return walk(merged) && take_whole_rings(merged);
  }

 private:
  const Outline& outline(int o) const { return o ? layer_ : above_; }

  // Edges of the layer are tested in groups: the edges of `above` near a group are searched once.
  void find_crossings() {
    constexpr std::uint32_t kAtOnce = 8;
    constexpr std::size_t kMaxNear = 32;
    const auto edges = std::uint32_t(layer_.next.size());
    struct Near {
      Lanes4 box;
      std::uint32_t edge;
    };
    std::vector<Near> near;
    BoxOf<std::int32_t> boxes[kAtOnce];
    for (std::uint32_t first = 0; first < edges; first += kAtOnce) {
      const std::uint32_t end = std::min(edges, first + kAtOnce);
      BoxOf<std::int32_t> all;
      for (std::uint32_t j = first; j < end; ++j) all.add(boxes[j - first] = layer_.box(j));
      near.clear();
      const bool many = tree_.any_touching(all, [&](std::size_t i) {
        near.push_back({packed(above_.box(i)), std::uint32_t(i)});
        return near.size() > kMaxNear;
      });
      for (std::uint32_t j = first; j < end && !near.empty(); ++j) {
        const BoxOf<std::int32_t>& box = boxes[j - first];
        if (many) {
          tree_.touching(box, [&](std::size_t i) { cross(std::uint32_t(i), j); });
          continue;
        }
        const Lanes4 reach = reach_of(packed(box));
        for (const Near& other : near)
          if (meets(other.box, reach)) cross(other.edge, j);
      }
    }
  }

  void cross(std::uint32_t i, std::uint32_t j) {
    const Point a = above_.at(i), b = above_.at(above_.next[i]), c = layer_.at(j),
                d = layer_.at(layer_.next[j]);
    const int c_side = side(a, b, c, 1), d_side = side(a, b, d, 1);
    if (c_side == d_side || side(c, d, a, -1) == side(c, d, b, -1)) return;
    const Int ax = Int(b.x) - a.x, ay = Int(b.y) - a.y, lx = Int(d.x) - c.x, ly = Int(d.y) - c.y;
    const Wide sine = cross_product(ax, ay, lx, ly);
    if (sine == 0) return;  // coinciding edges cross at their neighbours
    Crossing x;
    x.edge[0] = i;
    x.edge[1] = j;
    x.place[0] = place(cross_product(Int(c.x) - a.x, Int(c.y) - a.y, lx, ly), ly, -lx, sine);
    x.place[1] = place(cross_product(Int(a.x) - c.x, Int(a.y) - c.y, ax, ay), -ay, ax, -sine);
    const double t = double(x.place[0].value) / double(x.place[0].scale);
    x.at = to_point({a.x + t * double(ax), a.y + t * double(ay)});
    x.leaves = d_side < 0;
    crossings_.push_back(x);
  }

  // Sorts the crossings along each ring; `following` is cyclic.
  void order_along(int o) {
    std::vector<std::uint32_t>& order = order_[o];
    order.resize(crossings_.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const Crossing &x = crossings_[a], &y = crossings_[b];
      if (x.edge[o] != y.edge[o]) return x.edge[o] < y.edge[o];
      if (x.place[o] < y.place[o]) return true;
      if (y.place[o] < x.place[o]) return false;
      return a < b;
    });
    const std::vector<std::uint32_t>& ring = outline(o).ring;
    std::size_t begin = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const bool last = i + 1 == order.size() ||
                        ring[crossings_[order[i + 1]].edge[o]] != ring[crossings_[order[i]].edge[o]];
      crossings_[order[i]].following[o] = order[last ? begin : i + 1];
      if (last) begin = i + 1;
    }
  }

  // Returns whether the segment is within the tolerance of one edge of `above` of the same direction, or each
  // half of it is.
  bool hugs(Vec p, Vec q, int depth) const {
    BoxOf<std::int32_t> box;
    const Point lo = to_point({std::min(p.x, q.x), std::min(p.y, q.y)}),
                hi = to_point({std::max(p.x, q.x), std::max(p.y, q.y)});
    box.add(lo.x - tolerance_, lo.y - tolerance_);
    box.add(hi.x + tolerance_, hi.y + tolerance_);
    const auto alongside = [&](std::size_t i) {
      const Vec a = to_vec(above_.at(i)), way = to_vec(above_.at(above_.next[i])) - a;
      const double square = dot(way, way);
      if (dot(q - p, way) < 0 || square == 0) return false;
      const auto near = [&](Vec v) {
        const Vec off = v - a - std::clamp(dot(v - a, way) / square, 0.0, 1.0) * way;
        return dot(off, off) <= double(tolerance_) * tolerance_;
      };
      if (!near(p) || !near(q)) return false;
      beside_ = i;
      return true;
    };
    // Usually this is the edge beside the previous segment, or the next one.
    bool found = false;
    for (std::size_t i = beside_, tries = 0; tries < 2 && !found; ++tries, i = above_.next[i])
      found = above_.box(i).meets(box) && alongside(i);
    found = found || tree_.any_touching(box, alongside);
    if (found || depth == 0) return found;
    const Vec m = 0.5 * (p + q);
    return hugs(p, m, depth - 1) && hugs(m, q, depth - 1);
  }

  // A part of the layer that leaves `above`, returns at the next crossing of both outlines and stays within
  // the tolerance is a sliver: it is taken as if it had stayed inside.
  void drop_slivers() {
    for (std::uint32_t c = 0; c < crossings_.size(); ++c) {
      Crossing& out = crossings_[c];
      if (!out.leaves) continue;
      Crossing& back = crossings_[out.following[1]];
      if (back.leaves || out.following[0] != out.following[1]) continue;
      bool sliver = true;
      beside_ = out.edge[0];
      Vec p = to_vec(out.at);
      for_corners(1, c, out.following[1], [&](Point q) {
        sliver = sliver && hugs(p, to_vec(q), 6);
        p = to_vec(q);
      });
      sliver = sliver && hugs(p, to_vec(back.at), 6);
      if (sliver) out.active = back.active = false;
    }
  }

  // Calls f for the corners of outline o strictly between two consecutive crossings.
  template <class F>
  void for_corners(int o, std::uint32_t from, std::uint32_t to, F&& f) const {
    const Outline& line = outline(o);
    const std::uint32_t end = crossings_[to].edge[o];
    std::uint32_t e = crossings_[from].edge[o];
    // The path goes round the whole ring if the second crossing lies before the first on the same edge.
    if (e == end && (from == to || crossings_[to].place[o] < crossings_[from].place[o])) {
      e = line.next[e];
      f(line.at(e));
    }
    while (e != end) {
      e = line.next[e];
      f(line.at(e));
    }
  }

  // Follows the layer from each exit to its return, and `above` from there.
  bool walk(Region& merged) {
    for (std::uint32_t start = 0; start < crossings_.size(); ++start) {
      if (!crossings_[start].active || !crossings_[start].leaves || crossings_[start].visited) continue;
      std::vector<Point> ring;
      const auto add = [&](Point p) {
        if (ring.empty() || ring.back() != p) ring.push_back(p);
      };
      std::uint32_t c = start;
      int o = 1;
      std::size_t steps = 0;
      do {
        if (o == 1) {
          if (crossings_[c].visited) return false;
          crossings_[c].visited = true;
        }
        add(crossings_[c].at);
        for (;;) {
          const std::uint32_t to = crossings_[c].following[o];
          for_corners(o, c, to, add);
          c = to;
          if (++steps > 4 * crossings_.size() + 4) return false;
          if (crossings_[c].active && crossings_[c].leaves == (o == 0)) break;
        }
        o = 1 - o;
      } while (!(o == 1 && c == start));
      keep(merged, ring);
    }
    return true;
  }

  static void keep(Region& merged, std::vector<Point>& ring) {
    while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
    if (ring.size() >= 3 && twice_area(ring) != 0) merged.add(ring);
  }

  // Takes the rings without active crossings.
  bool take_whole_rings(Region& merged) {
    for (int o = 0; o < 2; ++o) {
      const Outline& line = outline(o);
      std::vector<char> crossed(line.region.size(), 0);  // 1: by slivers only, 2: by other crossings
      for (const Crossing& x : crossings_) {
        char& c = crossed[line.ring[x.edge[o]]];
        c = std::max(c, char(x.active ? 2 : 1));
      }
      for (std::uint32_t k = 0; k < line.region.size(); ++k) {
        if (crossed[k] == 2 || (crossed[k] == 1 && o == 1)) continue;
        const auto ring = line.region[k];
        if (crossed[k] == 0 && winding_about(outline(1 - o), ring[0], o ? 1 : -1) > 0) continue;
        merged.add(ring);
      }
    }
    return true;
  }

  Outline above_, layer_;
  std::int32_t tolerance_;
  StaticRTree tree_;
  mutable std::size_t beside_ = 0;  // an edge of `above` that is tested first
  std::vector<Crossing> crossings_;
  std::vector<std::uint32_t> order_[2];
};

// Returns the complement of the region within a frame `margin` units outside `box`; inverted_back() undoes
// it.
Region inverted(const Region& region, const BoxOf<std::int32_t>& box, std::int32_t margin) {
  Region around;
  const std::int32_t x0 = box.x0 - margin, y0 = box.y0 - margin, x1 = box.x1 + margin, y1 = box.y1 + margin;
  const Point frame[] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  around.add(frame);
  std::vector<Point> ring;
  for (std::size_t r = 0; r < region.size(); ++r) {
    ring.assign(region[r].rbegin(), region[r].rend());
    around.add(ring);
  }
  return around;
}

Region inverted_back(const Region& around, const BoxOf<std::int32_t>& box) {
  Region region;
  std::vector<Point> ring;
  for (std::size_t r = 0; r < around.size(); ++r) {
    if (std::any_of(around[r].begin(), around[r].end(), [&](Point p) { return p.x < box.x0; })) continue;
    ring.assign(around[r].rbegin(), around[r].rend());
    region.add(ring);
  }
  return region;
}

BoxOf<std::int32_t> box_of(const Region& a, const Region& b) {
  BoxOf<std::int32_t> box;
  for (const Point p : a.points) box.add(p.x, p.y);
  for (const Point p : b.points) box.add(p.x, p.y);
  return box;
}

constexpr std::int32_t kFrame = kUnitsPerMm;

}  // namespace

Region union_within(const Region& above, const Region& layer, std::int32_t tolerance) {
  if (above.empty() || layer.empty()) return above.empty() ? layer : above;
  Region merged;
  if (!TolerantUnion(above, layer, tolerance).run(merged)) return unite(above, layer);
  return merged;
}

Region difference_within(const Region& region, const Region& taken, std::int32_t tolerance) {
  if (region.empty() || taken.empty()) return region;
  const BoxOf<std::int32_t> box = box_of(region, taken);
  return inverted_back(union_within(inverted(region, box, kFrame), taken, tolerance), box);
}

Region intersection_within(const Region& region, const Region& bound, std::int32_t tolerance) {
  if (region.empty() || bound.empty()) return {};
  const BoxOf<std::int32_t> box = box_of(region, bound);
  return inverted_back(
      union_within(inverted(region, box, 2 * kFrame), inverted(bound, box, kFrame), tolerance), box);
}

}  // namespace firn::geometry
