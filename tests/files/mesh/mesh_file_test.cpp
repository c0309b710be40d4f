// Readers of STL, PLY, OBJ and 3MF: the same mesh from every format, and the errors for other files.
#include "files/mesh/mesh_file.h"

#include <unistd.h>
#include <zlib.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "files/usage_error.h"
#include "tests/support/mesh_samples.h"

using namespace firn;
using namespace firn::test;
namespace mb = firn::test::mesh_bytes;

namespace {

using Facet = std::array<slice::Corner, 3>;

std::vector<Facet> facets_of(const MeshData& data) {
  const slice::FacetView view = data.facets();
  std::vector<Facet> out;
  for (std::size_t n = 0; n < view.size(); ++n) out.push_back(view.facet(n));
  return out;
}
std::vector<Facet> facets_of(const SampleMesh& m) {
  std::vector<Facet> out;
  for (const auto& t : m.triangles) out.push_back({m.vertices[t[0]], m.vertices[t[1]], m.vertices[t[2]]});
  return out;
}

MeshData read(const std::vector<std::byte>& bytes, const std::string& name) { return read_mesh(bytes, name); }
MeshData read(const std::string& text, const std::string& name) {
  return read_mesh(std::as_bytes(std::span(text)), name);
}

std::string refusal(const std::string& text, const std::string& name) {
  try {
    read(text, name);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "nothing was refused";
}

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
    "face 1\n"
    "property list uchar int vertex_indices\nend_header\n";

}  // namespace

TEST_CASE("Every format gives the same facets") {
  const SampleMesh m = gear();
  const std::vector<Facet> want = facets_of(m);
  const auto same = [&](const std::vector<std::byte>& bytes, const std::string& name,
                        const std::string& format) {
    const MeshData data = read(bytes, name);
    INFO(format);
    CHECK(data.format == format);
    CHECK(data.mm_per_unit == 1.0);
    CHECK(data.defects.empty());
    CHECK(facets_of(data) == want);
  };
  same(mb::binary_stl(m), "a.stl", "binary STL");
  same(mb::ascii_stl(m), "a.STL", "ASCII STL");
  same(mb::binary_ply(m, false), "a.ply", "binary PLY");
  same(mb::binary_ply(m, true), "a.ply", "big-endian PLY");
  same(mb::binary_ply(m, false, true), "a.ply", "binary PLY");
  same(mb::binary_ply(m, true, true), "a.ply", "big-endian PLY");
  same(mb::ascii_ply(m), "a.ply", "ASCII PLY");
  same(mb::obj(m), "a.obj", "OBJ");
  same(mb::threemf(m), "a.3mf", "3MF");
}

TEST_CASE("A file cut at any byte is refused or reported, whatever its format") {
  const SampleMesh m = gear(2);
  const std::vector<Facet> want = facets_of(m);
  const auto cut = [&](const std::vector<std::byte>& bytes, const std::string& name, std::size_t step) {
    for (std::size_t n = 0; n < bytes.size(); n += step) {
      INFO(name << " cut to " << n << " of " << bytes.size() << " bytes");
      try {
        const MeshData data = read_mesh({bytes.data(), n}, name);
        // A file that reads without a defect is whole: at most the last line's end or word is missing.
        if (data.defects.empty()) CHECK(data.facets().size() == want.size());
      } catch (const UsageError& e) {
        CHECK(std::string(e.what()).starts_with(name));
      }
    }
  };
  cut(mb::binary_stl(m), "a.stl", 1);
  cut(mb::ascii_stl(m), "a.stl", 1);
  cut(mb::binary_ply(m, false, true), "a.ply", 1);
  cut(mb::binary_ply(m, true), "a.ply", 1);
  cut(mb::ascii_ply(m), "a.ply", 1);
  cut(mb::threemf(m), "a.3mf", 1);
}

TEST_CASE("OBJ files have no end mark: a cut one is refused where a face or number is torn") {
  CHECK(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "a.obj").find("a.obj:4: a face names vertex 4") == 0);
  CHECK(refusal("v 0 0\n", "a.obj").find("a.obj:1: ends where a coordinate is expected") == 0);
  CHECK(refusal("v 0 0 0\nf 1 2 -2\n", "a.obj").find("a.obj:2: a face names vertex -2") == 0);
  CHECK(refusal("v 0 0 0\n", "a.obj") == "a.obj: holds no facet");
  CHECK(facets_of(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "a.obj")).size() ==
        1);  // vertices may come later
  CHECK(read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\n3 4\nf 1 2\n", "a.obj").defects.size() == 1);
}

TEST_CASE("Convex polygons become fans") {
  const MeshData quad = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "a.obj");
  REQUIRE(quad.triangles.size() == 2);
  CHECK(quad.triangles[1] == std::array<std::uint32_t, 3>{0, 2, 3});
  CHECK(read("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
             "z\nelement face 2\nproperty list "
             "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n2 0 1\n",
             "a.ply")
            .triangles.size() == 2);
}

TEST_CASE("Headers that claim more than the file holds are refused before memory is taken") {
  std::vector<std::byte> stl(84 + 50);
  const std::uint32_t claim = 42'949'672;  // 2 GiB of facets
  std::memcpy(stl.data() + 80, &claim, 4);
  CHECK_THROWS_WITH(
      read(stl, "a.stl"),
      Catch::StartsWith("a.stl: byte 80: the header claims 42949672 facets, which take 2147483684 bytes; the "
                        "file has 134 bytes, enough for 1: "));
  for (const char* format : {"binary_little_endian", "binary_big_endian", "ascii"}) {
    INFO(format);
    const std::string head = std::string("ply\nformat ") + format + " 1.0\nelement vertex ";
    const std::string rest =
        "\nproperty float x\nproperty float y\nproperty float z\nelement face 2000000000\nproperty list "
        "uchar int "
        "vertex_indices\nend_header\n";
    CHECK(refusal(head + "178956970" + rest + "0 0 0\n", "a.ply")
              .find("the header claims 178956970 rows of vertex") != std::string::npos);
    CHECK(refusal(head + "0" + rest + "0 0 0\n", "a.ply").find("the header claims 2000000000 rows of face") !=
          std::string::npos);
    CHECK(refusal(head + "99999999999999999999" + rest, "a.ply").find("is not a whole number") !=
          std::string::npos);
  }
  CHECK(
      refusal(kPly + "0 0 0 1 0 0 0 1 0\n2000000000 0 1 2\n", "a.ply").find("a list of 2000000000 entries") !=
      std::string::npos);
}

TEST_CASE("Errors name line or byte and what is wrong there") {
  CHECK(refusal(kPly + "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n", "a.ply") ==
        "a.ply:11: a coordinate = x: is not a number");
  CHECK(refusal(kPly + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a.ply") ==
        "a.ply:13: face 0 names vertex 3; there are 3");
  CHECK(refusal("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "a.stl") ==
        "a.stl:5: ends where a coordinate is expected");
  CHECK(refusal("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\n", "a.stl") ==
        "a.stl:5: a facet with 1 vertices instead of 3");
  CHECK(refusal("PK nothing", "a.3mf").find("a.3mf: is no ZIP archive, as a 3MF file is, or is cut") == 0);
  CHECK(refusal("x", "a.step") == "a.step: must end in .stl, .ply, .obj or .3mf");
  CHECK(refusal("", "a.stl") == "a.stl: is empty");
  CHECK(refusal("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement "
                "vertex 1\nproperty float x\nproperty "
                "float y\nproperty float z\nend_header\n",
                "a.ply")
            .find("the faces stand before the vertices") != std::string::npos);
}

TEST_CASE("NaN and infinite vertices are handed on for the slicer to report") {
  const MeshData data = read(kPly + "nan 0 0\n1e999 0 0\n-1e-999 +2 0\n3 0 1 2\n", "a.ply");
  const Facet f = data.facets().facet(0);
  CHECK(std::isnan(f[0][0]));
  CHECK(std::isinf(f[1][0]));
  CHECK(f[2] == slice::Corner{0.0f, 2.0f, 0.0f});
}

TEST_CASE("Odd but readable files give defects") {
  std::vector<std::byte> stl = mb::binary_stl(gear(2));
  stl.resize(stl.size() + 7);
  CHECK(read(stl, "a.stl").defects == std::vector<std::string>{"7 bytes stand behind the last facet"});
  CHECK(read("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
             "0\nendloop\nendfacet\n",
             "a.stl")
            .defects == std::vector<std::string>{"the file ends without endsolid"});
  // A binary file may begin with "solid".
  stl = mb::binary_stl(gear(2));
  std::memcpy(stl.data(), "solid facet", 11);
  CHECK(read(stl, "a.stl").format == "binary STL");
}

TEST_CASE("3MF: build items place their objects, and the model names its unit") {
  const SampleMesh m = gear(3);
  const MeshData moved =
      read(mb::threemf(
               m, "<item objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 100 200 300\"/><item objectid=\"1\"/>",
               "inch"),
           "a.3mf");
  CHECK(moved.mm_per_unit == 25.4);
  REQUIRE(moved.vertices.size() == 2 * m.vertices.size());
  for (std::size_t v = 0; v < m.vertices.size(); ++v) {  // rows of the matrix are the images of x, y, z
    const std::array<double, 3> want{100.0 - m.vertices[v][1], 200.0 + m.vertices[v][0],
                                     300.0 + m.vertices[v][2]};
    for (std::size_t a = 0; a < 3; ++a)
      CHECK(moved.vertices[v][a] + moved.origin[a] == Approx(want[a]).epsilon(1e-7));
  }
}

TEST_CASE("3MF objects of type other are not printed, as items and as components, and the report says so") {
  const auto facets = [](const std::string& objects) { return read(mb::threemf_of(objects), "a.3mf"); };
  const std::string mesh = mb::threemf_mesh(gear(3));
  const auto object = [&](int id, const char* type, const std::string& inner) {
    return "<object id=\"" + std::to_string(id) + "\" type=\"" + type + "\">" + inner + "</object>";
  };
  const std::string both = object(1, "model", mesh) + object(2, "other", mesh);
  const MeshData data = facets(
      "<resources>" + both +
      object(3, "model", "<components><component objectid=\"1\"/><component objectid=\"2\"/></components>") +
      "</resources><build><item objectid=\"3\"/></build>");
  CHECK(data.triangles.size() == gear(3).triangles.size());
  CHECK(data.defects ==
        std::vector<std::string>{"object 2 is of type other, no part of the model: left out"});
}

TEST_CASE("3MF of components within components that multiply without end is refused with object and limit") {
  const auto nested = [](int levels, int each, int items) {
    std::string objects = "<object id=\"1\" type=\"model\">" + mb::threemf_mesh(gear(3)) + "</object>", build;
    for (int id = 2; id <= levels; ++id) {
      objects += "<object id=\"" + std::to_string(id) + "\" type=\"model\"><components>";
      for (int n = 0; n < each; ++n) objects += "<component objectid=\"" + std::to_string(id - 1) + "\"/>";
      objects += "</components></object>";
    }
    for (int n = 0; n < items; ++n) build += "<item objectid=\"" + std::to_string(levels) + "\"/>";
    const std::vector<std::byte> bytes =
        mb::threemf_of("<resources>" + objects + "</resources><build>" + build + "</build>");
    return refusal({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "a.3mf");
  };
  CHECK(nested(32, 4, 1) == "a.3mf: its items and components place more than 100000 objects, the limit");
  CHECK(nested(40, 1, 1) == "a.3mf: object 7: components within components, more than 32 deep");
  CHECK(nested(10, 3, 6) == "a.3mf: its items and components place more than 100000 objects, the limit");
  CHECK(nested(4, 3, 2) == "nothing was refused");
}

TEST_CASE("A 3MF archive that unpacks to a thousand times its size is refused with the limit") {
  const std::string blank(256 << 20, ' ');
  std::string packed(::compressBound(blank.size()), '\0');
  z_stream z{};
  REQUIRE(::deflateInit2(&z, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY) == Z_OK);
  z.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(blank.data()));
  z.avail_in = unsigned(blank.size());
  z.next_out = reinterpret_cast<unsigned char*>(packed.data());
  z.avail_out = unsigned(packed.size());
  REQUIRE(::deflate(&z, Z_FINISH) == Z_STREAM_END);
  packed.resize(z.total_out);
  ::deflateEnd(&z);
  const std::vector<std::byte> bytes = mb::threemf_archive(packed, std::uint32_t(blank.size()));
  const std::string why = refusal({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "a.3mf");
  CHECK(why.starts_with("a.3mf: 3D/3dmodel.model: unpacks to more than "));
}

TEST_CASE("ASCII STL is read with text behind its end tags, which is reported") {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop{}\nendfacet{}\n";
  const auto with = [&](const std::string& loop, const std::string& end, const std::string& behind) {
    std::string f = facet;
    f.replace(f.find("{}"), 2, loop);
    f.replace(f.find("{}"), 2, end);
    return "solid a\n" + f + "endsolid a\n" + behind;
  };
  const auto defects = [](std::size_t n) {
    return std::vector<std::string>{std::to_string(n) + " lines have text behind an end tag"};
  };
  CHECK(read(with("", "", ""), "a.stl").defects.empty());
  for (const char* behind : {"written by a program\n", "facet count: 1\n", "vertex 1 2 3\n", "; 1"}) {
    INFO(behind);
    const MeshData data = read(with("", "", behind), "a.stl");
    CHECK(facets_of(data).size() == 1);
    CHECK(data.defects == defects(1));
  }
  CHECK(read(with(" // 1", " 7", ""), "a.stl").defects == defects(2));
  CHECK(facets_of(read(with("", "", "remark\n" + with("", "", "")), "a.stl")).size() == 2);
  // All on one line, as some programs write it, is no remark.
  CHECK(read("solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet "
             "endsolid a\n",
             "a.stl")
            .defects.empty());
}

TEST_CASE("Text of another encoding or with carriage returns alone is named as such") {
  const SampleMesh m = gear(2);
  const auto string_of = [](const std::vector<std::byte>& bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  for (const auto& [text, name] : {std::pair{string_of(mb::ascii_stl(m)), std::string("a.stl")},
                                   std::pair{string_of(mb::obj(m)), std::string("a.obj")}}) {
    INFO(name);
    std::string wide, cr = text;
    for (const char c : text) wide += {c, '\0'};
    const std::string utf16 = name + ": byte 0: is UTF-16 text, where ASCII or UTF-8 is expected";
    CHECK(refusal(wide, name) == utf16);
    CHECK(refusal("\xff\xfe" + wide, name) == utf16);
    CHECK(refusal("\xfe\xff" + std::string(1, '\0') + wide.substr(0, wide.size() - 1), name) == utf16);
    CHECK(refusal(std::string(1, '\0') + wide.substr(0, wide.size() - 1), name) == utf16);
    std::ranges::replace(cr, '\n', '\r');
    CHECK(refusal(cr, name).find("lines end by carriage returns (CR) alone") != std::string::npos);
    CHECK(facets_of(read("\xef\xbb\xbf" + text, name)) == facets_of(m));
  }
}

TEST_CASE("A mapped STL may leave memory behind the slicer and still reads the same") {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("firn-mesh-" + std::to_string(getpid()) + ".stl");
  const SampleMesh m = gear(10'000);
  const std::vector<std::byte> bytes = mb::binary_stl(m);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  {
    const MeshFile mesh(file);
    const slice::FacetView view = mesh.facets();
    for (const bool follows : {true, false, false}) {
      std::vector<Facet> seen;
      for (std::size_t n = 0, told = 0; n < view.size(); ++n) {
        seen.push_back(view.facet(n));
        if (n % 10'000 == 9'999) view.done_with(std::exchange(told, n + 1), n + 1, follows);
      }
      CHECK(seen == facets_of(m));
    }
  }
  std::filesystem::remove(file);
  CHECK_THROWS_WITH(MeshFile("no/such.stl"), "no/such.stl: no such file");
}
