#include "studies/reproduce/barnett/box_part.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/path/path.h"

namespace firn::barnett {
namespace {

constexpr double kDiagonalShare = std::numbers::sqrt2 - 1.0;
constexpr double kRayStep_mm = 0.05;
constexpr int kHalvings = 6;    // of a step: 1 um
constexpr int kJawPoints = 60;  // across a jaw

// Counter-clockwise from the corner (-x-y), `outward` of the box's outline; as many points whatever the
// offset.
std::vector<Point2> outline(const BoxPart& b, double outward_mm) {
  std::vector<Point2> out;
  const double half = 0.5 * b.side_mm + outward_mm;
  for (int k = 0; k < 4; ++k) {
    const double r = std::max(0.0, b.round_mm[std::size_t(k)] + outward_mm),
                 first = (2 + k) * 0.5 * std::numbers::pi;
    const double x = (k == 0 || k == 3 ? -1.0 : 1.0) * (half - r), y = (k < 2 ? -1.0 : 1.0) * (half - r);
    for (int n = 0; n <= b.round_edges; ++n) {
      const double a = first + 0.5 * std::numbers::pi * n / b.round_edges;
      out.push_back({x + r * std::cos(a), y + r * std::sin(a)});
    }
  }
  return out;
}

double at(const HeightMap& h, double x_mm, double y_mm) {
  const GridSpec& g = h.spec;
  const double u = std::clamp((x_mm - g.origin_x_mm) / g.pitch_x_mm, 0.0, g.nx - 1.001);
  const double v = std::clamp((y_mm - g.origin_y_mm) / g.pitch_y_mm, 0.0, g.ny - 1.001);
  const int i = int(u), j = int(v);
  const double s = u - i, t = v - j;
  return (1 - t) * ((1 - s) * h.at(i, j) + s * h.at(i + 1, j)) +
         t * ((1 - s) * h.at(i, j + 1) + s * h.at(i + 1, j + 1));
}

/// Returns the distance by which a jaw that comes from `from` along `way` (a unit vector) moves until it
/// touches ice thicker than `level` over `crush` of its width.
double until_touch(const HeightMap& ice, Point2 from, Point2 way, double level_mm, const Caliper& caliper,
                   double max_mm) {
  const auto touches = [&](double s) {
    int ice_there = 0;
    for (int n = 0; n <= kJawPoints; ++n) {
      const double aside = (double(n) / kJawPoints - 0.5) * caliper.jaw_mm;
      ice_there += at(ice, from.x_mm + s * way.x_mm - aside * way.y_mm,
                      from.y_mm + s * way.y_mm + aside * way.x_mm) > level_mm;
    }
    return ice_there > 0 && caliper.jaw_mm * ice_there / (kJawPoints + 1) >= caliper.crush_mm;
  };
  double s = 0.0;
  while (s < max_mm && !touches(s)) s += kRayStep_mm;
  if (s == 0.0 || s >= max_mm) return std::min(s, max_mm);
  double before = s - kRayStep_mm;
  for (int n = 0; n < kHalvings; ++n) (touches(0.5 * (before + s)) ? s : before) = 0.5 * (before + s);
  return s;
}

double between_jaws(const HeightMap& ice, Point2 a, Point2 b, double level_mm, const Caliper& caliper) {
  const double length = std::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm);
  const Point2 way{(b.x_mm - a.x_mm) / length, (b.y_mm - a.y_mm) / length};
  return length - until_touch(ice, a, way, level_mm, caliper, length) -
         until_touch(ice, b, {-way.x_mm, -way.y_mm}, level_mm, caliper, length);
}

double thickest(const HeightMap& ice, Point2 p, double jaw_mm) {
  double most = 0.0;
  for (double y = -0.5 * jaw_mm; y <= 0.5 * jaw_mm + 1e-9; y += 0.1 * jaw_mm)
    for (double x = -0.5 * jaw_mm; x <= 0.5 * jaw_mm + 1e-9; x += 0.1 * jaw_mm)
      most = std::max(most, at(ice, p.x_mm + x, p.y_mm + y));
  return most;
}

}  // namespace

double BoxPart::diagonal_mm() const {
  return std::numbers::sqrt2 * side_mm - kDiagonalShare * (round_mm[0] + round_mm[2]);
}

SampleMesh mesh_of(const BoxPart& b, bool plate_on_top) {
  SampleMesh m;
  // The profile swept along the outline: plate's edge, ledge, wall's outside, rim, wall's inside.
  const double profile[6][2] = {{b.ledge_mm, 0.0},  {b.ledge_mm, b.plate_mm},  {0.0, b.plate_mm},
                                {0.0, b.height_mm}, {-b.wall_mm, b.height_mm}, {-b.wall_mm, b.plate_mm}};
  const auto points = std::uint32_t(4 * (b.round_edges + 1));
  const auto z_of = [&](double z) { return float(plate_on_top ? b.height_mm - z : z); };
  const auto triangle = [&](std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    const auto same = [&](std::uint32_t s, std::uint32_t t) { return m.vertices[s] == m.vertices[t]; };
    if (same(p, q) || same(q, r) || same(r, p)) return;  // at the sharp corner
    if (plate_on_top)
      m.triangles.push_back({p, r, q});
    else
      m.triangles.push_back({p, q, r});
  };
  for (const auto& [outward, z] : profile)
    for (const Point2& p : outline(b, outward)) m.vertices.push_back({float(p.x_mm), float(p.y_mm), z_of(z)});
  const auto middle = std::uint32_t(m.vertices.size());
  m.vertices.push_back({0.0f, 0.0f, z_of(0.0)});
  m.vertices.push_back({0.0f, 0.0f, z_of(b.plate_mm)});
  for (std::uint32_t n = 0; n < points; ++n) {
    const std::uint32_t next = (n + 1) % points;
    for (std::uint32_t k = 0; k < 5; ++k) {
      const std::uint32_t low = k * points, high = low + points;
      triangle(low + n, low + next, high + next);
      triangle(low + n, high + next, high + n);
    }
    triangle(middle, next, n);
    triangle(middle + 1, 5 * points + n, 5 * points + next);
  }
  return m;
}

std::vector<Dimension> measured(const BoxPart& b, const HeightMap& ice, std::span<const WallBand> bands,
                                const Caliper& caliper) {
  const double half = 0.5 * b.side_mm, step = b.height_mm - b.plate_mm, middle = b.plate_mm + 0.5 * step;
  const double clear = half + 0.5 * b.ledge_mm, off = half + b.ledge_mm + 3.0,
               inside = half - 2.0 * b.wall_mm;
  const double shares[] = {-0.2, -0.07, 0.07, 0.2};
  std::vector<Dimension> d{{"l1", "wall", b.wall_mm, {}},
                           {"l2", "plate", b.plate_mm, {}},
                           {"l3", "diagonal from the sharp corner", b.diagonal_mm(), {}},
                           {"l4", "across the plate", b.side_mm + 2.0 * b.ledge_mm, {}},
                           {"l5", "across the box, x", b.side_mm, {}},
                           {"l6", "height", b.height_mm, {}},
                           {"l7", "across the box, y", b.side_mm, {}}};
  constexpr Point2 kWays[] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (const Point2& w : kWays) {
    const auto out = [&](double r) { return Point2{r * w.x_mm, r * w.y_mm}; };
    d[0].measured_mm.push_back(between_jaws(ice, out(clear), out(inside), middle, caliper));
    d[1].measured_mm.push_back(thickest(ice, out(half + 0.6 * b.ledge_mm), caliper.jaw_mm));
    d[5].measured_mm.push_back(thickest(ice, out(half - 0.5 * b.wall_mm), caliper.jaw_mm));
  }
  for (int n = 0; n < 4; ++n) {
    const double aside = shares[n] * b.side_mm;
    d[4].measured_mm.push_back(between_jaws(ice, {-clear, aside}, {clear, aside}, middle, caliper));
    d[6].measured_mm.push_back(between_jaws(ice, {aside, -clear}, {aside, clear}, middle, caliper));
    d[3].measured_mm.push_back(
        n % 2 ? between_jaws(ice, {aside, -off}, {aside, off}, 0.5 * b.plate_mm, caliper)
              : between_jaws(ice, {-off, aside}, {off, aside}, 0.5 * b.plate_mm, caliper));
  }
  for (const WallBand& band : bands)
    d[2].measured_mm.push_back(
        between_jaws(band.ice, {-clear, -clear}, {clear, clear}, 0.5 * band.height_mm, caliper));
  if (bands.empty())
    d[2].measured_mm.push_back(between_jaws(ice, {-clear, -clear}, {clear, clear}, middle, caliper));
  return d;
}

}  // namespace firn::barnett
