// Draws solids of axis-parallel boxes, whose area and volume a grid of their own sides gives exactly, and
// writes them in every format that firn reads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "tests/support/mesh_samples.h"

namespace firn::test {

using Vec3 = std::array<double, 3>;

struct Box3 {
  Vec3 low, high;
};

/// A body without a hole: its boxes share faces only. Faces are polygons, seen from outside
/// counter-clockwise.
struct BoxBody {
  std::vector<Box3> boxes;
  std::vector<Vec3> vertices;
  std::vector<std::vector<std::uint32_t>> faces;
};

/// An upright box, or an L whose outline begins at its hollow corner, from where a fan covers it.
inline BoxBody drawn_body(RandomStream& random) {
  const auto half = [&](int low, int high) {
    return 0.5 * (low + int(random.below(std::uint32_t(high - low))));
  };
  const double x = half(-30, 30), y = half(-30, 30), z = half(0, 20), width = half(8, 24),
               depth = half(8, 24), height = half(4, 24);
  BoxBody body;
  std::vector<std::array<double, 2>> outline;
  if (random.below(2) == 0) {
    outline = {{x, y}, {x + width, y}, {x + width, y + depth}, {x, y + depth}};
    body.boxes = {{{x, y, z}, {x + width, y + depth, z + height}}};
  } else {
    const double u = half(2, 7), v = half(2, 7);
    outline = {{x + u, y + v}, {x + u, y + depth}, {x, y + depth},
               {x, y},         {x + width, y},     {x + width, y + v}};
    body.boxes = {{{x, y, z}, {x + width, y + v, z + height}},
                  {{x, y + v, z}, {x + u, y + depth, z + height}}};
  }
  const auto n = std::uint32_t(outline.size());
  for (const double level : {z, z + height})
    for (const auto& p : outline) body.vertices.push_back({p[0], p[1], level});
  std::vector<std::uint32_t> bottom, top;
  for (std::uint32_t k = 0; k < n; ++k) {
    bottom.push_back(k == 0 ? 0 : n - k);
    top.push_back(n + k);
    const std::uint32_t next = (k + 1) % n;
    body.faces.push_back({k, next, n + next, n + k});
  }
  body.faces.push_back(bottom);
  body.faces.push_back(top);
  return body;
}

/// Axes permuted and turned about, with a shift: boxes stay boxes.
struct BoxTransform {
  std::array<std::size_t, 3> from{0, 1, 2};  ///< axis of the body that becomes this one
  Vec3 sign{1, 1, 1}, shift{};
  Vec3 operator()(const Vec3& p) const {
    Vec3 q;
    for (std::size_t a = 0; a < 3; ++a) q[a] = sign[a] * p[from[a]] + shift[a];
    return q;
  }
  bool mirrors() const {
    const int swaps = (from[0] > from[1]) + (from[0] > from[2]) + (from[1] > from[2]);
    return sign[0] * sign[1] * sign[2] * (swaps % 2 ? -1.0 : 1.0) < 0.0;
  }
  /// As 3MF has it: rows are the images of the axes.
  std::string text() const {
    std::string out;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t a = 0; a < 3; ++a) out += (from[a] == row ? std::to_string(int(sign[a])) : "0") + " ";
    for (const double s : shift) out += std::to_string(s) + " ";
    return out;
  }
};

inline BoxTransform drawn_transform(RandomStream& random) {
  BoxTransform t;
  for (std::size_t a = 2; a > 0; --a) std::swap(t.from[a], t.from[random.below(std::uint32_t(a + 1))]);
  for (std::size_t a = 0; a < 3; ++a) {
    t.sign[a] = random.below(2) ? 1.0 : -1.0;
    t.shift[a] = 0.5 * random.below(20);
  }
  return t;
}

inline BoxBody transformed(BoxBody body, const BoxTransform& t) {
  for (Vec3& v : body.vertices) v = t(v);
  for (Box3& b : body.boxes) {
    const Vec3 p = t(b.low), q = t(b.high);
    for (std::size_t a = 0; a < 3; ++a) {
      b.low[a] = std::min(p[a], q[a]);
      b.high[a] = std::max(p[a], q[a]);
    }
  }
  if (t.mirrors())
    for (auto& face : body.faces) std::reverse(face.begin() + 1, face.end());
  return body;
}

inline double volume_of(const std::vector<BoxBody>& bodies) {
  double sum = 0.0;
  for (const BoxBody& body : bodies)
    for (const Box3& b : body.boxes)
      sum += (b.high[0] - b.low[0]) * (b.high[1] - b.low[1]) * (b.high[2] - b.low[2]);
  return sum;
}

inline double lowest_of(const std::vector<BoxBody>& bodies) {
  double low = 1e300;
  for (const BoxBody& body : bodies)
    for (const Box3& b : body.boxes) low = std::min(low, b.low[2]);
  return low;
}

/// Area of all boxes at a height, counted once where they overlap.
inline double area_at(const std::vector<BoxBody>& bodies, double z) {
  std::vector<Box3> cut;
  std::set<double> xs, ys;
  for (const BoxBody& body : bodies)
    for (const Box3& b : body.boxes)
      if (b.low[2] < z && z < b.high[2]) {
        cut.push_back(b);
        xs.insert({b.low[0], b.high[0]});
        ys.insert({b.low[1], b.high[1]});
      }
  double area = 0.0;
  for (auto x = xs.begin(); x != xs.end() && std::next(x) != xs.end(); ++x)
    for (auto y = ys.begin(); y != ys.end() && std::next(y) != ys.end(); ++y) {
      const double mx = 0.5 * (*x + *std::next(x)), my = 0.5 * (*y + *std::next(y));
      const bool in = std::any_of(cut.begin(), cut.end(), [&](const Box3& b) {
        return b.low[0] < mx && mx < b.high[0] && b.low[1] < my && my < b.high[1];
      });
      if (in) area += (*std::next(x) - *x) * (*std::next(y) - *y);
    }
  return area;
}

namespace box_bytes {

using mesh_bytes::Bytes;
using mesh_bytes::put;
using mesh_bytes::text;

inline std::string digits(double v) {
  char s[40];
  std::snprintf(s, sizeof s, "%.12g", v);
  return s;
}
inline std::string digits(const Vec3& p, const Vec3& shift) {
  return digits(p[0] + shift[0]) + " " + digits(p[1] + shift[1]) + " " + digits(p[2] + shift[2]);
}

template <class Facet>
void for_fans(const BoxBody& body, const Facet& facet) {
  for (const auto& face : body.faces)
    for (std::size_t c = 2; c < face.size(); ++c) facet(face[0], face[c - 1], face[c]);
}

inline Bytes ascii_stl(const std::vector<BoxBody>& bodies, const Vec3& shift) {
  Bytes out;
  for (const BoxBody& body : bodies) {
    text(out, "solid body\n");
    for_fans(body, [&](auto... corners) {
      text(out, "facet normal 0 0 0\nouter loop\n");
      for (const std::uint32_t v : {corners...})
        text(out, "vertex " + digits(body.vertices[v], shift) + "\n");
      text(out, "endloop\nendfacet\n");
    });
    text(out, "endsolid body\n");
  }
  return out;
}

inline Bytes binary_stl(const std::vector<BoxBody>& bodies) {
  Bytes out(84);
  std::uint32_t count = 0;
  for (const BoxBody& body : bodies)
    for_fans(body, [&](auto... corners) {
      out.resize(out.size() + 12);
      for (const std::uint32_t v : {corners...})
        for (const double c : body.vertices[v]) put(out, float(c));
      put(out, std::uint16_t(0));
      ++count;
    });
  std::memcpy(out.data() + 80, &count, sizeof count);
  return out;
}

/// Polygons begin at any corner.
inline Bytes obj(const std::vector<BoxBody>& bodies, const Vec3& shift, RandomStream& random) {
  Bytes out;
  std::size_t before = 0;
  for (const BoxBody& body : bodies) {
    text(out, "o body\n");
    for (const Vec3& v : body.vertices) text(out, "v " + digits(v, shift) + "\n");
    for (const auto& face : body.faces) {
      const bool relative = random.below(2), long_line = random.below(2);
      const std::size_t first = random.below(std::uint32_t(face.size()));
      text(out, "f");
      for (std::size_t c = 0; c < face.size(); ++c) {
        const std::uint32_t v = face[(first + c) % face.size()];
        text(out, " " + (relative ? std::to_string(std::int64_t(v) - std::int64_t(body.vertices.size()))
                                  : std::to_string(before + v + 1)));
        if (long_line && c == 1) text(out, random.below(2) ? "\\\n" : " \\\n");
      }
      text(out, "\n");
    }
    before += body.vertices.size();
  }
  return out;
}

/// Polygons as in obj(), coordinates as doubles. @param form "ascii", "binary_little_endian",
/// "binary_big_endian"
inline Bytes ply(const std::vector<BoxBody>& bodies, const Vec3& shift, const std::string& form,
                 RandomStream& random) {
  Bytes out, faces;
  std::size_t vertices = 0, count = 0;
  const bool big = form == "binary_big_endian", is_text = form == "ascii";
  Bytes points;
  for (const BoxBody& body : bodies) {
    for (const Vec3& v : body.vertices) {
      if (is_text) text(points, digits(v, shift) + "\n");
      for (std::size_t a = 0; a < 3 && !is_text; ++a) put(points, v[a] + shift[a], big);
    }
    for (const auto& face : body.faces) {
      const std::size_t first = random.below(std::uint32_t(face.size()));
      if (is_text)
        text(faces, std::to_string(face.size()));
      else
        put(faces, std::uint16_t(face.size()), big);
      for (std::size_t c = 0; c < face.size(); ++c) {
        const std::size_t v = vertices + face[(first + c) % face.size()];
        if (is_text)
          text(faces, " " + std::to_string(v));
        else
          put(faces, std::uint16_t(v), big);
      }
      if (is_text) text(faces, "\n");
      ++count;
    }
    vertices += body.vertices.size();
  }
  text(out, "ply\nformat " + form + " 1.0\nelement vertex " + std::to_string(vertices) +
                "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                std::to_string(count) + "\nproperty list ushort ushort vertex_indices\nend_header\n");
  out.insert(out.end(), points.begin(), points.end());
  out.insert(out.end(), faces.begin(), faces.end());
  return out;
}

/// The <mesh> of a body.
inline std::string threemf_mesh(const BoxBody& body) {
  std::string mesh = "<mesh><vertices>";
  for (const Vec3& v : body.vertices)
    mesh += "<vertex x=\"" + digits(v[0]) + "\" y=\"" + digits(v[1]) + "\" z=\"" + digits(v[2]) + "\"/>";
  mesh += "</vertices><triangles>";
  for_fans(body, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh += "<triangle v1=\"" + std::to_string(a) + "\" v2=\"" + std::to_string(b) + "\" v3=\"" +
            std::to_string(c) + "\"/>";
  });
  return mesh + "</triangles></mesh>";
}

}  // namespace box_bytes
}  // namespace firn::test
