// Returns meshes made in code, and their bytes in every format that firn reads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace firn::test {

struct SampleMesh {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// An upright prism over a star-shaped outline about (cx, cy), closed.
template <class Radius>
SampleMesh prism(std::uint32_t corners, float height, float cx, float cy, Radius radius) {
  SampleMesh m;
  for (std::uint32_t n = 0; n < corners; ++n) {
    const double a = 2 * std::numbers::pi * n / corners, r = radius(n);
    for (float z : {0.0f, height})
      m.vertices.push_back({cx + float(r * std::cos(a)), cy + float(r * std::sin(a)), z});
  }
  const std::uint32_t bottom = 2 * corners, top = bottom + 1;
  m.vertices.push_back({cx, cy, 0.0f});
  m.vertices.push_back({cx, cy, height});
  for (std::uint32_t n = 0; n < corners; ++n) {
    const std::uint32_t a = 2 * n, b = 2 * ((n + 1) % corners);
    m.triangles.push_back({a, b, b + 1});
    m.triangles.push_back({a, b + 1, a + 1});
    m.triangles.push_back({bottom, b, a});
    m.triangles.push_back({top, a + 1, b + 1});
  }
  return m;
}

/// A gear wheel: `teeth` teeth of four corners each.
inline SampleMesh gear(std::uint32_t teeth = 12, float height = 5.0f, double outer = 15.0,
                       double inner = 12.0) {
  return prism(4 * teeth, height, 20.0f, 20.0f, [=](std::uint32_t n) { return n % 4 < 2 ? outer : inner; });
}

namespace mesh_bytes {

using Bytes = std::vector<std::byte>;

inline void text(Bytes& out, const std::string& s) {
  const auto* p = reinterpret_cast<const std::byte*>(s.data());
  out.insert(out.end(), p, p + s.size());
}
template <class T>
void put(Bytes& out, T value, bool big_endian = false) {
  std::array<std::byte, sizeof(T)> raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  if (big_endian) std::reverse(raw.begin(), raw.end());
  out.insert(out.end(), raw.begin(), raw.end());
}
inline std::string digits(float v) {
  char s[40];
  std::snprintf(s, sizeof s, "%.9g", double(v));
  return s;
}

inline Bytes binary_stl(const SampleMesh& m) {
  Bytes out(80);
  put(out, std::uint32_t(m.triangles.size()));
  for (const auto& t : m.triangles) {
    out.resize(out.size() + 12);
    for (std::uint32_t v : t)
      for (float c : m.vertices[v]) put(out, c);
    put(out, std::uint16_t(0));
  }
  return out;
}

inline Bytes ascii_stl(const SampleMesh& m) {
  Bytes out;
  text(out, "solid sample\n");
  for (const auto& t : m.triangles) {
    text(out, "facet normal 0 0 0\n outer loop\n");
    for (std::uint32_t v : t)
      text(out, "  vertex " + digits(m.vertices[v][0]) + " " + digits(m.vertices[v][1]) + " " +
                    digits(m.vertices[v][2]) + "\n");
    text(out, " endloop\nendfacet\n");
  }
  text(out, "endsolid sample\n");
  return out;
}

/// With a colour per vertex and a quality per face, which readers must pass over.
inline Bytes binary_ply(const SampleMesh& m, bool big_endian, bool extras = false) {
  Bytes out;
  text(out, std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
                " 1.0\ncomment sample\nelement vertex " + std::to_string(m.vertices.size()) +
                "\nproperty float x\nproperty float y\n" + (extras ? "property uchar red\n" : "") +
                "property float z\nelement face " + std::to_string(m.triangles.size()) + "\n" +
                (extras ? "property double quality\n" : "") +
                "property list uchar int vertex_indices\nend_header\n");
  for (const auto& v : m.vertices) {
    put(out, v[0], big_endian);
    put(out, v[1], big_endian);
    if (extras) put(out, std::uint8_t(200));
    put(out, v[2], big_endian);
  }
  for (const auto& t : m.triangles) {
    if (extras) put(out, 0.5, big_endian);
    put(out, std::uint8_t(3));
    for (std::uint32_t v : t) put(out, std::int32_t(v), big_endian);
  }
  return out;
}

inline Bytes ascii_ply(const SampleMesh& m) {
  Bytes out;
  text(out, "ply\r\nformat ascii 1.0\r\nelement vertex " + std::to_string(m.vertices.size()) +
                "\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nelement face " +
                std::to_string(m.triangles.size()) +
                "\r\nproperty list uchar int vertex_index\r\nend_header\r\n");
  for (const auto& v : m.vertices) text(out, digits(v[0]) + " " + digits(v[1]) + " " + digits(v[2]) + "\r\n");
  for (const auto& t : m.triangles)
    text(out, "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\r\n");
  return out;
}

inline Bytes obj(const SampleMesh& m) {
  Bytes out;
  text(out, "# sample\no part\n");
  for (const auto& v : m.vertices)
    text(out, "v " + digits(v[0]) + " " + digits(v[1]) + " " + digits(v[2]) + "\n");
  text(out, "vn 0 0 1\nusemtl grey\n");
  bool relative = false;
  for (const auto& t : m.triangles) {
    text(out, "f");
    for (std::uint32_t v : t)
      text(out, relative ? " " + std::to_string(std::int64_t(v) - std::int64_t(m.vertices.size()))
                         : " " + std::to_string(v + 1) + "//1");
    text(out, "\n");
    relative = !relative;
  }
  return out;
}

inline std::uint32_t crc32(const std::string& s) {
  std::uint32_t crc = 0xffffffffu;
  for (unsigned char c : s) {
    crc ^= c;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

/// The <mesh> element of a 3MF object.
inline std::string threemf_mesh(const SampleMesh& m) {
  std::string mesh = "<mesh><vertices>";
  for (const auto& v : m.vertices)
    mesh += "<vertex x=\"" + digits(v[0]) + "\" y=\"" + digits(v[1]) + "\" z=\"" + digits(v[2]) + "\"/>";
  mesh += "</vertices><triangles>";
  for (const auto& t : m.triangles)
    mesh += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" +
            std::to_string(t[2]) + "\"/>";
  return mesh + "</triangles></mesh>";
}

using Parts = std::vector<std::pair<std::string, std::string>>;

/// A 3MF file. @param model as it lies in the archive: stored, or deflated with the number of bytes it
/// unpacks to. @param more parts of the archive: name and content
inline Bytes threemf_archive(const std::string& model, std::uint32_t deflated_from = 0,
                             const Parts& more = {}) {
  Parts files = {{"[Content_Types].xml",
                  "<?xml version=\"1.0\" encoding=\"UTF-8\"?><Types "
                  "xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default "
                  "Extension=\"rels\" "
                  "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default "
                  "Extension=\"model\" "
                  "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>"},
                 {"_rels/.rels",
                  "<?xml version=\"1.0\" encoding=\"UTF-8\"?><Relationships "
                  "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
                  "Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
                  "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
                 {"3D/3dmodel.model", model}};
  files.insert(files.end(), more.begin(), more.end());
  Bytes out, directory;
  for (const auto& file : files) {
    const std::string &name = file.first, &content = file.second;
    const auto offset = std::uint32_t(out.size());
    const auto common =
        [&](Bytes& to) {  // version, flags, stored, time, date, checksum, sizes, name, no extra field
          const bool deflated = deflated_from > 0 && &file == &files[2];
          for (const int v : {20, 0, deflated ? 8 : 0, 0, 0x21}) put(to, std::uint16_t(v));
          put(to, crc32(content));
          put(to, std::uint32_t(content.size()));
          put(to, deflated ? deflated_from : std::uint32_t(content.size()));
          put(to, std::uint16_t(name.size()));
          put(to, std::uint16_t(0));
        };
    put(out, std::uint32_t(0x04034b50));
    common(out);
    text(out, name + content);
    put(directory, std::uint32_t(0x02014b50));
    put(directory, std::uint16_t(20));
    common(directory);
    for (int n = 0; n < 3; ++n) put(directory, std::uint16_t(0));
    put(directory, std::uint32_t(0));
    put(directory, offset);
    text(directory, name);
  }
  const auto begin = std::uint32_t(out.size());
  out.insert(out.end(), directory.begin(), directory.end());
  put(out, std::uint32_t(0x06054b50));
  for (const std::size_t v : {std::size_t(0), std::size_t(0), files.size(), files.size()})
    put(out, std::uint16_t(v));
  put(out, std::uint32_t(directory.size()));
  put(out, begin);
  put(out, std::uint16_t(0));
  return out;
}

/// A model part. @param content of the <model>: resources and build. @param attributes further ones
inline std::string threemf_model(const std::string& content, const std::string& unit = "millimeter",
                                 const std::string& attributes = {}) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"" + unit +
         "\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
         "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" "
         "xmlns:s=\"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07\" " +
         attributes + ">" + content + "</model>";
}

inline Bytes threemf_of(const std::string& content, const std::string& unit = "millimeter") {
  return threemf_archive(threemf_model(content, unit));
}

inline Bytes threemf_with(const std::string& content, const Parts& more, const std::string& attributes = {}) {
  return threemf_archive(threemf_model(content, "millimeter", attributes), 0, more);
}

/// @param item the <item …/> of the build
inline Bytes threemf(const SampleMesh& m, const std::string& item = "<item objectid=\"1\"/>",
                     const std::string& unit = "millimeter") {
  return threemf_of("<resources><object id=\"1\" type=\"model\">" + threemf_mesh(m) +
                        "</object></resources><build>" + item + "</build>",
                    unit);
}

}  // namespace mesh_bytes
}  // namespace firn::test
