#include "estimators/surface/scattered_surface.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

namespace firn::surface {
namespace {

constexpr float kHalfPlane_mm =
    1e5F;  // the outer triangle is so far away that it takes nothing from the hull
constexpr double kFarthest_mm = 1e4;
constexpr int kFirstVertex = 4;  // of ours: 0 is not used, 1 to 3 are the outer triangle's

}  // namespace

struct ScatteredSurface::State {
  cv::Subdiv2D net;
  double x0_mm = 0.0, y0_mm = 0.0;
  std::vector<double> x, y, sum, count;  // by vertex

  // Where Subdiv2D can insert the point: there, or beside it. Its search walks from edge to edge in rounded
  // arithmetic, and where triangles are needles it may go round in circles for ever; a point some micrometres
  // aside is another way.
  std::optional<cv::Point2f> place_of(double px, double py) {
    constexpr double kAside_mm = 0.004;
    int edge = 0, vertex = 0;
    for (const auto& [dx, dy] : {std::pair(0.0, 0.0), std::pair(1.0, 0.3), std::pair(-0.3, 1.0),
                                 std::pair(-1.0, -0.3), std::pair(0.3, -1.0)}) {
      const cv::Point2f p(float(px + kAside_mm * dx), float(py + kAside_mm * dy));
      if (net.locate(p, edge, vertex) != cv::Subdiv2D::PTLOC_ERROR) return p;
    }
    return std::nullopt;
  }

  double z(int v) const { return sum[std::size_t(v)] / count[std::size_t(v)]; }
  bool real(int v) const { return v >= kFirstVertex; }

  double along(int a, int b, double px, double py) const {
    const std::size_t i = std::size_t(a), j = std::size_t(b);
    const double dx = x[j] - x[i], dy = y[j] - y[i], length2 = dx * dx + dy * dy;
    const double t =
        length2 > 0.0 ? std::clamp(((px - x[i]) * dx + (py - y[i]) * dy) / length2, 0.0, 1.0) : 0.0;
    return z(a) + t * (z(b) - z(a));
  }

  double inside(int edge, double px, double py) {
    const int next = net.getEdge(edge, cv::Subdiv2D::NEXT_AROUND_LEFT);
    const int a = net.edgeOrg(edge), b = net.edgeDst(edge), c = net.edgeDst(next);
    if (!real(a) || !real(b) || !real(c)) return kNotMeasured;
    const std::size_t i = std::size_t(a), j = std::size_t(b), k = std::size_t(c);
    const double ux = x[j] - x[i], uy = y[j] - y[i], vx = x[k] - x[i], vy = y[k] - y[i], wx = px - x[i],
                 wy = py - y[i];
    const double area = ux * vy - uy * vx;
    if (area == 0.0) return along(a, b, px, py);
    const double s = (wx * vy - wy * vx) / area, t = (ux * wy - uy * wx) / area;
    return z(a) + s * (z(b) - z(a)) + t * (z(c) - z(a));
  }
};

ScatteredSurface::ScatteredSurface(std::span<const SurfacePoint> points) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.net.initDelaunay(
      cv::Rect(int(-kHalfPlane_mm), int(-kHalfPlane_mm), int(2 * kHalfPlane_mm), int(2 * kHalfPlane_mm)));
  s.x.assign(kFirstVertex, 0.0);
  s.y = s.sum = s.count = s.x;
  bool first = true;
  for (const SurfacePoint& p : points) {
    if (!std::isfinite(p.x_mm) || !std::isfinite(p.y_mm) || !std::isfinite(p.z_mm)) continue;
    if (first) {
      s.x0_mm = p.x_mm;
      s.y0_mm = p.y_mm;
      first = false;
    }
    const double x = p.x_mm - s.x0_mm, y = p.y_mm - s.y0_mm;
    if (std::abs(x) > kFarthest_mm || std::abs(y) > kFarthest_mm)
      throw std::invalid_argument("scattered points lie more than 10 m apart");
    const std::optional<cv::Point2f> place = s.place_of(x, y);
    if (!place) continue;
    const std::size_t v = std::size_t(s.net.insert(*place));
    if (v >= s.x.size()) {
      s.x.resize(v + 1);
      s.y.resize(v + 1);
      s.sum.resize(v + 1);
      s.count.resize(v + 1);
      s.x[v] = x;
      s.y[v] = y;
    }
    s.sum[v] += p.z_mm;
    s.count[v] += 1.0;
  }
}

ScatteredSurface::~ScatteredSurface() = default;
ScatteredSurface::ScatteredSurface(ScatteredSurface&&) noexcept = default;

std::size_t ScatteredSurface::points() const { return state_->x.size() - kFirstVertex; }

double ScatteredSurface::at(double x_mm, double y_mm) {
  State& s = *state_;
  const double x = x_mm - s.x0_mm, y = y_mm - s.y0_mm;
  if (!(std::abs(x) < kHalfPlane_mm && std::abs(y) < kHalfPlane_mm)) return kNotMeasured;
  int edge = 0, vertex = 0;
  switch (s.net.locate(cv::Point2f(float(x), float(y)), edge, vertex)) {
    case cv::Subdiv2D::PTLOC_INSIDE:
      return s.inside(edge, x, y);
    case cv::Subdiv2D::PTLOC_VERTEX:
      return s.real(vertex) ? s.z(vertex) : kNotMeasured;
    case cv::Subdiv2D::PTLOC_ON_EDGE: {
      const int a = s.net.edgeOrg(edge), b = s.net.edgeDst(edge);
      return s.real(a) && s.real(b) ? s.along(a, b, x, y) : kNotMeasured;
    }
    default:
      return kNotMeasured;
  }
}

HeightMap ScatteredSurface::on(const GridSpec& grid, int samples) {
  check(grid);
  if (samples < 1)
    throw std::invalid_argument("a cell's mean over " + std::to_string(samples) + " places a side");
  HeightMap h(grid, kNotMeasured);
  if (samples > 1) {
    const double dx = grid.pitch_x_mm / samples, dy = grid.pitch_y_mm / samples;
    const GridSpec parts{grid.nx * samples,
                         grid.ny * samples,
                         dx,
                         dy,
                         grid.origin_x_mm + 0.5 * (dx - grid.pitch_x_mm),
                         grid.origin_y_mm + 0.5 * (dy - grid.pitch_y_mm)};
    const HeightMap fine = on(parts);
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        double sum = 0.0, n = 0.0;
        for (int y = j * samples; y < (j + 1) * samples; ++y)
          for (int x = i * samples; x < (i + 1) * samples; ++x)
            if (std::isfinite(fine.at(x, y))) {
              sum += fine.at(x, y);
              n += 1.0;
            }
        if (n > 0.0) h.at(i, j) = sum / n;
      }
    return h;
  }
  for (int j = 0; j < grid.ny; ++j)
    for (int n = 0; n < grid.nx; ++n) {
      const int i = j % 2 ? grid.nx - 1 - n : n;  // to and fro: the search begins at the cell before
      h.at(i, j) = at(grid.x_mm(i), grid.y_mm(j));
    }
  return h;
}

void fill_from_nearest(HeightMap& h) {
  const GridSpec& g = h.spec;
  std::vector<std::size_t> front, next;
  for (std::size_t c = 0; c < h.size(); ++c)
    if (std::isfinite(h.cells[c])) front.push_back(c);
  for (; !front.empty(); front.swap(next), next.clear())
    for (const std::size_t c : front) {
      const int i = int(c) % g.nx, j = int(c) / g.nx;
      for (int y = std::max(j - 1, 0); y <= std::min(j + 1, g.ny - 1); ++y)
        for (int x = std::max(i - 1, 0); x <= std::min(i + 1, g.nx - 1); ++x)
          if (!std::isfinite(h.at(x, y))) {
            h.at(x, y) = h.cells[c];
            next.push_back(g.index(x, y));
          }
    }
}

}  // namespace firn::surface
