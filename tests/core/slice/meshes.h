// Meshes made in code for the slicer's tests: orderly ones and broken ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/grid/random.h"
#include "core/slice/mesh/facets.h"
#include "tests/support/mesh_samples.h"

namespace firn::test {

inline slice::FacetView view(const SampleMesh& m) {
  slice::FacetView v;
  v.vertices = m.vertices;
  v.triangles = m.triangles;
  return v;
}

inline SampleMesh both(SampleMesh a, const SampleMesh& b) {
  const auto offset = std::uint32_t(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

inline SampleMesh inside_out(SampleMesh m) {
  for (auto& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

inline SampleMesh moved(SampleMesh m, float x, float y, float z, float scale = 1.0f) {
  for (auto& v : m.vertices) v = {v[0] * scale + x, v[1] * scale + y, v[2] * scale + z};
  return m;
}

inline SampleMesh box(float x0, float y0, float z0, float x1, float y1, float z1) {
  SampleMesh m;
  for (int i = 0; i < 8; ++i) m.vertices.push_back({i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? z1 : z0});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

/// Axis along z, standing on z = 0 with some play to stay off planes.
inline SampleMesh torus(float big, float small, std::uint32_t around, std::uint32_t across) {
  SampleMesh m;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across,
                   r = big + small * std::cos(v);
      m.vertices.push_back(
          {float(r * std::cos(u)), float(r * std::sin(u)), float(small + small * std::sin(v))});
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return (i % around) * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

inline SampleMesh sphere(float x, float y, float z, float r, std::uint32_t around = 48,
                         std::uint32_t bands = 24) {
  SampleMesh m;
  for (std::uint32_t b = 1; b < bands; ++b)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double v = std::numbers::pi * b / bands, u = 2 * std::numbers::pi * i / around;
      m.vertices.push_back({float(x + r * std::sin(v) * std::cos(u)),
                            float(y + r * std::sin(v) * std::sin(u)), float(z - r * std::cos(v))});
    }
  const auto south = std::uint32_t(m.vertices.size()), north = south + 1;
  m.vertices.push_back({x, y, z - r});
  m.vertices.push_back({x, y, z + r});
  const auto at = [&](std::uint32_t b, std::uint32_t i) { return b * around + i % around; };
  for (std::uint32_t i = 0; i < around; ++i) {
    m.triangles.push_back({south, at(0, i + 1), at(0, i)});
    m.triangles.push_back({north, at(bands - 2, i), at(bands - 2, i + 1)});
    for (std::uint32_t b = 0; b + 2 < bands; ++b) {
      m.triangles.push_back({at(b, i), at(b, i + 1), at(b + 1, i + 1)});
      m.triangles.push_back({at(b, i), at(b + 1, i + 1), at(b + 1, i)});
    }
  }
  return m;
}

/// `count` spheres that run into each other.
inline SampleMesh spheres(std::uint32_t count = 44, std::uint64_t seed = 1) {
  RandomStream random(seed, Purpose::kTest);
  SampleMesh m;
  for (std::uint32_t n = 0; n < count; ++n) {
    const float r = float(random.uniform(2.0, 5.0));
    m = both(std::move(m), sphere(float(random.uniform(6, 24)), float(random.uniform(6, 24)),
                                  float(random.uniform(r, 20)), r));
  }
  return m;
}

/// A sphere with a spherical hole in which a sphere floats.
inline SampleMesh nested_shells() {
  return both(both(sphere(0, 0, 12, 12), inside_out(sphere(0, 0, 12, 9))), sphere(0, 0, 12, 5));
}

/// One side, one border: bounds nothing.
inline SampleMesh moebius(std::uint32_t around = 120) {
  SampleMesh m;
  for (std::uint32_t i = 0; i < around; ++i)
    for (int j = 0; j < 2; ++j) {
      const double u = 2 * std::numbers::pi * i / around, w = j ? 4.0 : -4.0, r = 15 + w * std::cos(u / 2);
      m.vertices.push_back({float(r * std::cos(u)), float(r * std::sin(u)), float(6 + w * std::sin(u / 2))});
    }
  for (std::uint32_t i = 0; i < around; ++i) {
    const bool last = i + 1 == around;
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    m.triangles.push_back({a, c, d});
    m.triangles.push_back({a, d, b});
  }
  return m;
}

/// A box one of whose walls is split at a point of the common edge that the other wall does not know.
inline SampleMesh t_junctions() {
  SampleMesh m = box(0, 0, 0, 20, 20, 10);
  m.vertices.push_back({20, 0, 4.3f});  // on the edge of the walls y = 0 (corners 0 1 4 5) and x = 20
  m.triangles[4] = {0, 1, 8};
  m.triangles[5] = {0, 8, 5};
  m.triangles.push_back({0, 5, 4});
  return m;
}

inline SampleMesh single_triangle() { return {{{0, 0, 0}, {10, 0, 5}, {0, 10, 5}}, {{0, 1, 2}}}; }

/// The box with facets that have corners at no place.
inline SampleMesh with_nan() {
  SampleMesh m = box(0, 0, 0, 10, 10, 10);
  const float nan = std::numeric_limits<float>::quiet_NaN(), far = std::numeric_limits<float>::infinity();
  m.vertices.push_back({nan, 1, 1});
  m.vertices.push_back({1, far, 1});
  m.vertices.push_back({1, 1, -far});
  m.triangles.push_back({0, 1, 8});
  m.triangles.push_back({9, 1, 2});
  m.triangles.push_back({10, 10, 10});
  return m;
}

/// Facets in another order, each begun at another corner.
inline SampleMesh shuffled(SampleMesh m, std::uint64_t seed) {
  RandomStream random(seed, Purpose::kTest);
  for (std::size_t n = m.triangles.size(); n > 1; --n)
    std::swap(m.triangles[n - 1], m.triangles[random.below(std::uint32_t(n))]);
  for (auto& t : m.triangles) std::rotate(t.begin(), t.begin() + random.below(3), t.end());
  return m;
}

/// Every facet with its own three vertices.
inline SampleMesh unwelded(const SampleMesh& m) {
  SampleMesh soup;
  for (const auto& t : m.triangles) {
    const auto n = std::uint32_t(soup.vertices.size());
    for (const std::uint32_t c : t) soup.vertices.push_back(m.vertices[c]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  return soup;
}

}  // namespace firn::test
