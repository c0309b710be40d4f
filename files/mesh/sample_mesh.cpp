#include "files/mesh/sample_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

namespace firn {
namespace {

constexpr double kHeight_mm = 172.75;

double bell(double z, double centre, double width) {
  return std::exp(-(z - centre) * (z - centre) / (width * width));
}

// Radius of the figure at the fraction z of its height.
double radius_mm(double angle, double z) {
  const double robe = 42.0 * std::sqrt(1.0 - 0.55 * z) + 9.0 * bell(z, 0.62, 0.12);
  const double neck = 1.0 - 0.62 * bell(z, 0.80, 0.055),
               crown = std::sqrt(std::max(0.0, 1.0 - std::pow(std::max(0.0, (z - 0.86) / 0.14), 3.0)));
  const double folds = 2.4 * (1.0 - z) * std::sin(9.0 * angle + 5.0 * z) +
                       1.1 * std::sin(23.0 * angle - 11.0 * z) * bell(z, 0.35, 0.3);
  const double arms =
      11.0 * bell(z, 0.55, 0.13) * (std::pow(std::cos(angle), 6.0) + 0.4 * std::pow(std::sin(angle), 8.0));
  const double grain = 0.08 * std::sin(140.0 * angle) * std::sin(400.0 * z);
  return std::max(0.5, (robe + folds + arms) * neck * crown * 0.9 + grain);
}

template <class T>
void put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string ply_header(const SampleMesh& m, const char* format) {
  return fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement "
      "face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      format, m.vertices.size(), m.triangles.size());
}

}  // namespace

SampleMesh statue(std::uint32_t around, std::uint32_t up) {
  if (around < 3 || up < 3) throw std::invalid_argument("a statue needs 3 corners around and up");
  SampleMesh m;
  for (std::uint32_t j = 0; j < up; ++j) {
    const double z = double(j) / (up - 1);
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / around, r = radius_mm(angle, z);
      m.vertices.push_back({float(60.0 + r * std::cos(angle)), float(50.0 + 0.8 * r * std::sin(angle)),
                            float(kHeight_mm * z)});
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return j * around + i % around; };
  for (std::uint32_t j = 0; j + 1 < up; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  for (const std::uint32_t j : {0u, up - 1}) {
    const auto centre = std::uint32_t(m.vertices.size());
    m.vertices.push_back({60.0f, 50.0f, float(kHeight_mm * j / (up - 1))});
    for (std::uint32_t i = 0; i < around; ++i) {
      if (j)
        m.triangles.push_back({centre, at(i, j), at(i + 1, j)});
      else
        m.triangles.push_back({centre, at(i + 1, j), at(i, j)});
    }
  }
  return m;
}

std::string mesh_bytes(const SampleMesh& m, MeshFormat format) {
  std::string out;
  const auto line = [&](const char* before, const slice::Corner& c) {
    fmt::format_to(std::back_inserter(out), "{}{:.6e} {:.6e} {:.6e}\n", before, c[0], c[1], c[2]);
  };
  switch (format) {
    case MeshFormat::kBinaryPly:
      out = ply_header(m, "binary_little_endian");
      for (const slice::Corner& v : m.vertices) put(out, v);
      for (const auto& t : m.triangles) {
        put(out, std::uint8_t(3));
        put(out, t);
      }
      break;
    case MeshFormat::kAsciiPly:
      out = ply_header(m, "ascii");
      for (const slice::Corner& v : m.vertices) line("", v);
      for (const auto& t : m.triangles)
        fmt::format_to(std::back_inserter(out), "3 {} {} {}\n", t[0], t[1], t[2]);
      break;
    case MeshFormat::kBinaryStl:
      out.assign(80, '\0');
      put(out, std::uint32_t(m.triangles.size()));
      for (const auto& t : m.triangles) {
        out.append(12, '\0');
        for (std::uint32_t v : t) put(out, m.vertices[v]);
        out.append(2, '\0');
      }
      break;
    case MeshFormat::kAsciiStl:
      out = "solid statue\n";
      for (const auto& t : m.triangles) {
        out += "facet normal 0.000000e+00 0.000000e+00 0.000000e+00\n  outer loop\n";
        for (std::uint32_t v : t) line("    vertex ", m.vertices[v]);
        out += "  endloop\nendfacet\n";
      }
      out += "endsolid statue\n";
  }
  return out;
}

}  // namespace firn
