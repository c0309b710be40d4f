#include "files/mesh/cut_polygon.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace firn::mesh {
namespace {

struct Flat {
  double u, v;
  bool operator==(const Flat&) const = default;
};

double turn(const Flat& a, const Flat& b, const Flat& c) {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

bool is_within(const Flat& p, const Flat& a, const Flat& b, const Flat& c) {
  return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

/// Seen along its normal, counter-clockwise: the axis along which it is widest is left out.
std::vector<Flat> flattened(std::span<const std::uint32_t> corners, std::span<const slice::Corner> vertices) {
  std::array<double, 3> normal{};
  const auto at = [&](std::size_t n, std::size_t axis) {
    return double(vertices[corners[n]][axis]) - double(vertices[corners[0]][axis]);
  };
  for (std::size_t n = 0; n < corners.size(); ++n) {
    const std::size_t next = n + 1 == corners.size() ? 0 : n + 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      normal[axis] += (at(n, u) - at(next, u)) * (at(n, v) + at(next, v));
    }
  }
  std::size_t axis = 0;
  for (const std::size_t other : {1u, 2u})
    if (std::abs(normal[other]) > std::abs(normal[axis])) axis = other;
  std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0.0) std::swap(u, v);
  std::vector<Flat> flat;
  flat.reserve(corners.size());
  for (std::size_t n = 0; n < corners.size(); ++n) flat.push_back({at(n, u), at(n, v)});
  return flat;
}

class Clipper {
 public:
  explicit Clipper(std::vector<Flat> points) : points_(std::move(points)) {
    const auto n = std::uint32_t(points_.size());
    before_.resize(n);
    after_.resize(n);
    for (std::uint32_t k = 0; k < n; ++k) {
      before_[k] = k == 0 ? n - 1 : k - 1;
      after_[k] = k + 1 == n ? 0 : k + 1;
    }
    for (std::uint32_t k = 0; k < n; ++k)
      if (bend(k) <= 0.0) hollow_.push_back(k);
  }

  bool run(std::size_t& tests, std::vector<Triangle>& out) {
    auto left = std::uint32_t(points_.size());
    std::uint32_t at = 0, looked = 0;
    while (left > 3) {
      const bool any = looked >= 2 * left;  // the polygon crosses itself, or the rest is one line
      const bool straight = looked >= left;
      const double b = bend(at);
      if (any || ((b > 0.0 || (straight && b == 0.0)) && is_ear(at, tests))) {
        out.push_back({before_[at], at, after_[at]});
        clip(at);
        at = before_[at];
        --left;
        looked = 0;
      } else {
        at = after_[at];
        ++looked;
      }
      if (tests == 0) return false;
    }
    out.push_back({before_[at], at, after_[at]});
    return true;
  }

 private:
  double bend(std::uint32_t k) const { return turn(points_[before_[k]], points_[k], points_[after_[k]]); }

  // Only a corner that does not bend outward can lie within an ear.
  bool is_ear(std::uint32_t k, std::size_t& tests) const {
    const Flat &a = points_[before_[k]], &b = points_[k], &c = points_[after_[k]];
    for (const std::uint32_t h : hollow_) {
      tests -= tests > 0;
      const Flat& p = points_[h];
      if (p == a || p == b || p == c) continue;
      if (is_within(p, a, b, c)) return false;
    }
    return true;
  }

  void clip(std::uint32_t k) {
    after_[before_[k]] = after_[k];
    before_[after_[k]] = before_[k];
    std::erase_if(hollow_, [&](std::uint32_t h) {
      return h == k || ((h == before_[k] || h == after_[k]) && bend(h) > 0.0);
    });
  }

  std::vector<Flat> points_;
  std::vector<std::uint32_t> before_, after_, hollow_;
};

}  // namespace

bool is_convex(std::span<const std::uint32_t> corners, std::span<const slice::Corner> vertices) {
  const std::vector<Flat> flat = flattened(corners, vertices);
  for (std::size_t n = 0; n < flat.size(); ++n)
    if (turn(flat[n], flat[(n + 1) % flat.size()], flat[(n + 2) % flat.size()]) < 0.0) return false;
  return true;
}

bool cut_polygon(std::span<const std::uint32_t> corners, std::span<const slice::Corner> vertices,
                 std::size_t& tests, std::span<Triangle> out) {
  std::vector<Triangle> cut;
  cut.reserve(out.size());
  if (!Clipper(flattened(corners, vertices)).run(tests, cut)) return false;
  std::ranges::transform(cut, out.begin(), [&](const Triangle& t) {
    return Triangle{corners[t[0]], corners[t[1]], corners[t[2]]};
  });
  return true;
}

}  // namespace firn::mesh
