// Mesh files as their makers meant them: marks of other programs in STL, PLY, OBJ and 3MF are followed,
// told in words, or refused by name.
#include <catch2/catch.hpp>

#include <algorithm>

#include "core/geometry/planar.h"
#include "core/slice/mesh/slicer.h"
#include "files/mesh/mesh_file.h"
#include "files/usage_error.h"
#include "tests/support/mesh_samples.h"

namespace firn::test {
namespace {

namespace mb = mesh_bytes;
using Catch::Contains;

SampleMesh cube(float x = 0.0f, float side = 10.0f, float z = 0.0f) {
  SampleMesh m;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back({x + (i & 1 ? side : 0.0f), i & 2 ? side : 0.0f, z + (i & 4 ? side : 0.0f)});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

std::string object(int id, const std::string& inner, const std::string& attributes = {}) {
  return "<object id=\"" + std::to_string(id) + "\" " + attributes + ">" + inner + "</object>";
}
std::string model(const std::string& objects, const std::string& items = "<item objectid=\"1\"/>") {
  return "<resources>" + objects + "</resources><build>" + items + "</build>";
}
const std::string kCube = mb::threemf_mesh(cube());

MeshData read_foreign(const mb::Bytes& bytes, const std::string& name,
                      FacetCount count = FacetCount::kAgree) {
  return read_mesh(bytes, name, count);
}
MeshData read_foreign(const std::string& text, const std::string& name,
                      FacetCount count = FacetCount::kAgree) {
  return read_mesh(std::as_bytes(std::span(text)), name, count);
}
template <class Input>
std::string refusal(const Input& input, const std::string& name, FacetCount count = FacetCount::kAgree) {
  try {
    read_foreign(input, name, count);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "nothing was refused";
}
std::string words(const MeshData& data) {
  std::string all;
  for (const std::string& d : data.defects) all += d + "\n";
  return all;
}
slice::Sliced sliced(const MeshData& data) {
  slice::SliceOptions options;
  options.layer_height_mm = 1.0;
  options.chord_tolerance_mm = 0.0;
  slice::Placement p;
  p.translation = {{{slice::AxisPlace::Mode::kCentre, 0.0},
                    {slice::AxisPlace::Mode::kCentre, 0.0},
                    {slice::AxisPlace::Mode::kNumber, 0.0}}};
  return slice::slice(data.facets(), p, options, serially);
}
double area(const MeshData& data, std::size_t layer = 0) {
  return geometry::area_mm2(sliced(data).layers.at(layer));
}

constexpr const char* kPrusa = "Metadata/Slic3r_PE_model.config";
constexpr const char* kBambu = "Metadata/model_settings.config";

std::string prusa_volume(int first, int last, const std::string& type) {
  return "<volume firstid=\"" + std::to_string(first) + "\" lastid=\"" + std::to_string(last) +
         "\"><metadata type=\"volume\" key=\"name\" value=\"v\"/><metadata type=\"volume\" "
         "key=\"volume_type\" "
         "value=\"" +
         type + "\"/></volume>";
}

/// Two cubes in one object; the second has a role of PrusaSlicer's.
mb::Bytes with_prusa_role(const std::string& type) {
  SampleMesh two = cube();
  for (const auto& v : cube(20.0f).vertices) two.vertices.push_back(v);
  for (const auto& t : cube().triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  return mb::threemf_with(model(object(1, mb::threemf_mesh(two))),
                          {{kPrusa, "<config><object id=\"1\">" + prusa_volume(0, 11, "ModelPart") +
                                        prusa_volume(12, 23, type) + "</object></config>"}});
}

/// The same as components with subtypes of Bambu Studio's and OrcaSlicer's.
mb::Bytes with_bambu_role(const std::string& subtype) {
  return mb::threemf_with(
      model(object(1, kCube) + object(2, mb::threemf_mesh(cube(20.0f))) +
                object(3, "<components><component objectid=\"1\"/><component objectid=\"2\"/></components>"),
            "<item objectid=\"3\"/>"),
      {{kBambu, "<config><object id=\"3\"><part id=\"1\" subtype=\"normal_part\"/><part id=\"2\" subtype=\"" +
                    subtype + "\"><metadata key=\"name\" value=\"v\"/></part></object></config>"}});
}

}  // namespace

TEST_CASE("A negative volume of a slicer is refused by its name, whichever slicer wrote it") {
  CHECK_THAT(
      refusal(with_prusa_role("NegativeVolume"), "a.3mf"),
      Contains("a.3mf: object 1, volume \"v\": its role is NegativeVolume") && Contains("export again"));
  CHECK_THAT(refusal(with_bambu_role("negative_part"), "a.3mf"),
             Contains("object 2, volume \"v\": its role is negative_part"));
  CHECK_THAT(refusal(with_prusa_role("SomethingNew"), "a.3mf"), Contains("its role is SomethingNew"));
}

TEST_CASE("Modifiers, support enforcers and blockers of slicers are no material, and the report says so") {
  for (const char* type : {"ParameterModifier", "SupportEnforcer", "SupportBlocker"}) {
    const MeshData data = read_foreign(with_prusa_role(type), "a.3mf");
    CHECK(area(data) == Approx(100.0));
    CHECK_THAT(words(data), Contains(type) && Contains("left out"));
  }
  for (const char* type : {"modifier_part", "support_enforcer", "support_blocker"}) {
    const MeshData data = read_foreign(with_bambu_role(type), "a.3mf");
    CHECK(area(data) == Approx(100.0));
    CHECK_THAT(words(data), Contains(type) && Contains("left out"));
  }
  CHECK(area(read_foreign(with_prusa_role("ModelPart"), "a.3mf")) == Approx(200.0));
  CHECK(area(read_foreign(with_bambu_role("normal_part"), "a.3mf")) == Approx(200.0));
}

TEST_CASE("Meshes that Cura marks as no material are left out") {
  for (const char* key : {"support_mesh", "anti_overhang_mesh", "infill_mesh", "cutting_mesh"}) {
    const std::string mark = std::string("<metadatagroup><metadata name=\"cura:") + key +
                             "\" preserve=\"1\" type=\"xs:string\">True</metadata></metadatagroup>";
    const MeshData data =
        read_foreign(mb::threemf_of(model(object(1, kCube) + object(2, mark + kCube),
                                          "<item objectid=\"1\"/><item objectid=\"2\" transform=\"1 "
                                          "0 0 0 1 0 0 0 1 30 0 0\"/>")),
                     "a.3mf");
    CHECK(area(data) == Approx(100.0));
    CHECK_THAT(words(data), Contains(key));
  }
}

TEST_CASE("A slicer's volume beyond the triangles of its mesh is refused with both numbers") {
  const mb::Bytes bytes = mb::threemf_with(
      model(object(1, kCube)),
      {{kPrusa, "<config><object id=\"1\">" + prusa_volume(0, 30, "ModelPart") + "</object></config>"}});
  CHECK_THAT(refusal(bytes, "a.3mf"), Contains("the triangles 0 to 31; the mesh has 12"));
}

TEST_CASE(
    "Items that are not to be printed and objects that are no part of the model are left out in words") {
  const std::string moved = " transform=\"1 0 0 0 1 0 0 0 1 30 0 0\"";
  const MeshData unprintable =
      read_foreign(mb::threemf_of(model(object(1, kCube), "<item objectid=\"1\"/><item objectid=\"1\"" +
                                                              moved + " printable=\"0\"/>")),
                   "a.3mf");
  CHECK(area(unprintable) == Approx(100.0));
  CHECK_THAT(words(unprintable), Contains("item 2 of the build (object 1) is not to be printed"));
  for (const char* type : {"support", "solidsupport", "surface", "other"}) {
    const MeshData data = read_foreign(
        mb::threemf_of(model(object(1, kCube) + object(2, kCube, std::string("type=\"") + type + "\""),
                             "<item objectid=\"1\"/><item objectid=\"2\"" + moved + "/>")),
        "a.3mf");
    CHECK(area(data) == Approx(100.0));
    CHECK_THAT(words(data), Contains(std::string("object 2 is of type ") + type));
  }
  CHECK_THAT(refusal(mb::threemf_of(model(object(1, kCube, "type=\"support\""))), "a.3mf"),
             Contains("holds no facet: object 1 is of type support"));
}

TEST_CASE(
    "A beam lattice, a stack of slices and a shape of another extension are refused where they are used") {
  const std::string beams = kCube.substr(0, kCube.rfind("</mesh>")) +
                            "<b:beamlattice radius=\"1\" minlength=\"0.1\"><b:beams/></b:beamlattice></mesh>";
  CHECK_THAT(refusal(mb::threemf_of(model(object(1, beams))), "a.3mf"),
             Contains("object 1 cannot be read: it has a beam lattice"));
  CHECK(area(read_foreign(mb::threemf_of(model(object(1, kCube) + object(2, beams))), "a.3mf")) ==
        Approx(100.0));
  CHECK_THAT(
      refusal(mb::threemf_of(model(object(1, kCube, "s:slicestackid=\"9\" s:meshresolution=\"lowres\""))),
              "a.3mf"),
      Contains("its solid is a stack of slices"));
  CHECK_THAT(refusal(mb::threemf_with(model(object(1, "<x:booleanshape/>")), {}, "xmlns:x=\"http://shapes\""),
                     "a.3mf"),
             Contains("neither a mesh nor components, but <booleanshape> of http://shapes"));
}

TEST_CASE("A required extension that is not read is refused by its address") {
  CHECK_THAT(refusal(mb::threemf_with(model(object(1, kCube)), {},
                                      "xmlns:v=\"http://volumes/2022\" requiredextensions=\"p v\""),
                     "a.3mf"),
             Contains("requires the extension v (http://volumes/2022)"));
  CHECK_THAT(refusal(mb::threemf_with(model(object(1, kCube)), {}, "requiredextensions=\"q\""), "a.3mf"),
             Contains("its namespace is not declared"));
  CHECK(area(read_foreign(mb::threemf_with(model(object(1, kCube)), {}, "requiredextensions=\"p b s\""),
                          "a.3mf")) == Approx(100.0));
}

TEST_CASE("Mirrored and inside-out bodies of 3MF overlap as solids do") {
  const std::string mirrored =
      "<components><component objectid=\"1\"/><component objectid=\"1\" "
      "transform=\"-1 0 0 0 1 0 0 0 1 15 0 0\"/></components>";
  CHECK(area(read_foreign(
            mb::threemf_of(model(object(1, kCube) + object(2, mirrored), "<item objectid=\"2\"/>")),
            "a.3mf")) == Approx(150.0));
  SampleMesh turned = cube(5.0f);
  for (auto& t : turned.triangles) std::swap(t[1], t[2]);
  const MeshData data =
      read_foreign(mb::threemf_of(model(object(1, kCube) + object(2, mb::threemf_mesh(turned)),
                                        "<item objectid=\"1\"/><item objectid=\"2\"/>")),
                   "a.3mf");
  CHECK(area(data) == Approx(150.0));
  CHECK_THAT(words(data), Contains("object 2: its triangles face inward: they were turned"));
}

TEST_CASE("A number of a 3MF file that goes on is refused with its text and place") {
  for (const char* wrong : {"2,5", "2.5mm", "1e", "nan", ""}) {
    std::string mesh = kCube;
    mesh.replace(mesh.find("x=\"10\"") + 3, 2, wrong);
    CHECK_THAT(refusal(mb::threemf_of(model(object(1, mesh))), "a.3mf"),
               Contains("a.3mf: 3D/3dmodel.model:2:") &&
                   Contains(std::string("x=\"") + wrong + "\": is not a number"));
  }
  CHECK_THAT(refusal(mb::threemf_of(model(object(1, kCube),
                                          "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 "
                                          "0 1 0 0\"/>")),
                     "a.3mf"),
             Contains("a transform of 11 numbers instead of 12"));
  CHECK_THAT(refusal(mb::threemf_of(model(object(1, kCube), "<item objectid=\"7\"/>")), "a.3mf"),
             Contains("there is no object 7, which the build names"));
}

/// Writes the mesh so that `change` has each element of its rows, which it may write in another way.
template <class Change>
std::string rewritten(const std::string& mesh, const Change& change) {
  std::string out;
  std::size_t at = 0;
  for (std::size_t n = 0, row = 0; (row = mesh.find("<", at)) != mesh.npos; at = row) {
    const std::size_t end = mesh.find('>', row) + 1;
    const std::string tag = mesh.substr(row, end - row);
    out += tag.ends_with("/>") ? change(tag, n++) : tag;
    row = end;
  }
  return out;
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

TEST_CASE("A mesh of many rows is the same however a 3MF file writes them") {
  const SampleMesh drawn = gear(700);  // some hundred kilobytes: it comes in several pieces
  const std::string mesh = mb::threemf_mesh(drawn);
  const auto changed = [](const std::string& tag, std::size_t n) {
    if (n % 97 == 0) return "<!-- > <vertex x=\"1\" y=\"1\" z=\"1\"/> -->" + tag;
    if (n % 89 == 0) return "<?note > <triangle v1=\"0\" v2=\"1\" v3=\"2\"/>?>" + tag;
    if (n % 83 == 0) return replaced(tag, "/>", "></") + tag.substr(1, tag.find(' ') - 1) + ">";
    if (n % 79 == 0) return replaced(tag, "/>", " note=\"> a\"/>");
    if (n % 73 == 0) return replaced(tag, "\"", "'");
    if (n % 71 == 0) return replaced(tag, "=\"", "=\" ");
    if (n % 67 == 0) return replaced(tag, " ", "\n\t");
    if (n % 61 == 0) return replaced(tag, "\"/>", "\" pid=\"1\"/>");
    return replaced(tag, "/>", " />\r\n");
  };
  const std::string prefixed = replaced(replaced(replaced(mesh, "</", "</c:"), "<", "<c:"), "<c:/c:", "</c:");
  const std::string other = replaced(prefixed, "<c:mesh>", "<c:mesh xmlns=\"urn:other\">");
  const std::string foreign =
      replaced(other, "<c:triangles>", "<c:triangles><triangle v1=\"0\" v2=\"2\" v3=\"4\"/>");
  for (const std::string& written : {mesh, rewritten(mesh, changed), prefixed, foreign}) {
    const MeshData data = read_foreign(
        mb::threemf_with(model(object(1, written)), {},
                         "xmlns:c=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\""),
        "a.3mf");
    CHECK(data.vertices == drawn.vertices);
    CHECK(data.triangles == drawn.triangles);
  }
}

TEST_CASE("A wrong row behind many others of a 3MF mesh is told with its line and column") {
  const std::string plain = mb::threemf_mesh(gear(700));
  const auto refused_at = [](std::string mesh, const std::string& row) {
    const std::size_t at = mesh.find(row) + row.find('"') + 1;
    mesh.insert(at, "?");
    const std::string part = mb::threemf_model(model(object(1, mesh)));
    const std::size_t begin = part.rfind('<', part.find('?', part.find("<mesh>")));
    const std::size_t line = part.rfind('\n', begin);
    return std::pair(refusal(mb::threemf_archive(part), "a.3mf"),
                     ":" + std::to_string(1 + std::ranges::count(part.substr(0, begin), '\n')) + ":" +
                         std::to_string(begin - line) + ":");
  };
  const std::string row = plain.substr(plain.find("<triangle v1=\"4000\""), 40);
  for (const std::string& mesh : {plain, replaced(plain, "/>", "/>\n"), replaced(plain, "/><", "/>\n  <"),
                                  replaced(plain, "v3=", "\nv3=")}) {
    const auto [refused, place] = refused_at(mesh, row.substr(0, 20));
    CHECK_THAT(refused, Contains(place));
  }
}

TEST_CASE("A decimal comma is refused with its text in every text format") {
  CHECK_THAT(refusal(std::string("v 0 0 0\nv 2,5 0 0\n"), "a.obj"), Contains("a.obj:2: a coordinate = 2,5"));
  CHECK_THAT(refusal(std::string("solid a\nfacet normal 0 0 1\nouter loop\nvertex 2,5 0 0\n"), "a.stl"),
             Contains("a coordinate = 2,5: is not a number; its decimal mark must be a point"));
}

TEST_CASE("Facets that name a vertex twice are left out and told with their place, in every indexed format") {
  std::string mesh = kCube;
  mesh.insert(mesh.find("</triangles>"),
              "<triangle v1=\"0\" v2=\"0\" v3=\"0\"/><triangle v1=\"1\" v2=\"2\" "
              "v3=\"1\"/>");
  const MeshData from_3mf = read_foreign(mb::threemf_of(model(object(1, mesh))), "a.3mf");
  CHECK(area(from_3mf) == Approx(100.0));
  CHECK_THAT(words(from_3mf), Contains("2 facets name a vertex twice") && Contains("triangle 13"));
  const mb::Bytes obj = mb::obj(cube());
  const std::string text(reinterpret_cast<const char*>(obj.data()), obj.size());
  CHECK_THAT(words(read_foreign(text + "f 1 2 2\n", "a.obj")), Contains("the first one at line 25"));
}

TEST_CASE("An STL whose header counts other facets than its size holds is refused with both, or chosen") {
  const mb::Bytes bytes = mb::binary_stl(cube());
  for (const std::uint32_t claimed : {0u, 6u, 40u}) {
    INFO(claimed);
    mb::Bytes wrong = bytes;
    std::memcpy(wrong.data() + 80, &claimed, sizeof claimed);
    CHECK_THAT(refusal(wrong, "a.stl"), Contains("claims " + std::to_string(claimed) + " facets") &&
                                            Contains("enough for 12") && Contains("mesh.facet_count"));
    const MeshData data = read_foreign(wrong, "a.stl", FacetCount::kFile);
    CHECK(area(data) == Approx(100.0));
    CHECK_THAT(words(data), Contains("the 12 that the file holds are read"));
  }
  mb::Bytes more = bytes;
  more.resize(more.size() + 500);
  CHECK(read_foreign(more, "a.stl", FacetCount::kHeader).facets().size() == 12);
  const mb::Bytes cut(bytes.begin(), bytes.end() - 60);
  CHECK_THAT(refusal(cut, "a.stl", FacetCount::kHeader), Contains("enough for 10"));
}

TEST_CASE("A PLY with more rows than its header claims is refused, or one of the counts is chosen") {
  for (const bool text : {true, false}) {
    const mb::Bytes ply = text ? mb::ascii_ply(cube()) : mb::binary_ply(cube(), false);
    std::string wrong(reinterpret_cast<const char*>(ply.data()), ply.size());
    wrong.replace(wrong.find("face 12") + 5, 2, "10");
    CHECK_THAT(refusal(wrong, "a.ply"), Contains("claims 10 rows of face") && Contains("mesh.facet_count"));
    CHECK(read_foreign(wrong, "a.ply", FacetCount::kHeader).triangles.size() == 10);
    CHECK(read_foreign(wrong, "a.ply", FacetCount::kFile).triangles.size() == 12);
  }
}

TEST_CASE("Text STL that begins with a remark, and binary STL that begins with solid, are known by content") {
  const mb::Bytes ascii = mb::ascii_stl(cube());
  std::string text(reinterpret_cast<const char*>(ascii.data()), ascii.size());
  CHECK(read_foreign("\n  \n" + text, "a.stl").format == "ASCII STL");
  CHECK_THAT(refusal("exported by a program\n" + text, "a.stl"),
             Contains("a.stl:1: unknown word \"exported\""));
  mb::Bytes binary = mb::binary_stl(cube());
  std::memcpy(binary.data(), "solid facet normal", 18);
  CHECK(read_foreign(binary, "a.stl").format == "binary STL");
}

TEST_CASE("Strips of triangles in PLY are refused by name, and vertices with lists are read") {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
      "property double z\n";
  CHECK_THAT(
      refusal(head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n", "a.ply"),
      Contains("the element tristrips (strips of triangles) is not read"));
  CHECK_THAT(refusal(head + "end_header\n0 0 0\n1 0 0\n0 1 0\n", "a.ply"), Contains("a cloud of points"));
  mb::Bytes lists;
  mb::text(lists,
           "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty list uchar short t\nproperty "
           "float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
           "vertex_indices\nend_header\n");
  for (int v = 0; v < 3; ++v) {
    mb::put(lists, std::uint8_t(v));
    for (int n = 0; n < v; ++n) mb::put(lists, std::int16_t(7), true);
    for (int a = 0; a < 3; ++a) mb::put(lists, float(v * 10 + a), true);
  }
  mb::put(lists, std::uint8_t(3));
  for (int v = 0; v < 3; ++v) mb::put(lists, std::int32_t(v), true);
  CHECK(read_foreign(lists, "a.ply").facets().facet(0)[2] == slice::Corner{20.0f, 21.0f, 22.0f});
}

TEST_CASE("OBJ lines go on behind a backslash, also within a word, and free-form surfaces are told") {
  const std::string text = "v 0 0\\\n 0\nv 1 0 0\nv 0 1 0\nf 1 2\\\n 3\nsurf 0 1 0 1 1 2\\\n 3\n";
  const MeshData data = read_foreign(text, "a.obj");
  CHECK(data.triangles.size() == 1);
  CHECK_THAT(words(data), Contains("1 free-form surfaces"));
}

TEST_CASE("A concave face gives facets that do not overlap: the slicer finds no defect") {
  const MeshData u = read_foreign(
      std::string("v 0 0 0\nv 10 0 0\nv 10 0 10\nv 7 0 10\nv 7 0 3\nv 3 0 3\nv 3 0 10\nv 0 0 10\n"
                  "v 0 10 0\nv 10 10 0\nv 10 10 10\nv 7 10 10\nv 7 10 3\nv 3 10 3\nv 3 10 "
                  "10\nv 0 10 10\nf 1 2 3 4 5 6 7 8\nf 16 15 14 13 12 11 10 9\nf 9 10 2 1\nf 10 11 "
                  "3 2\nf 11 12 4 3\nf 12 13 5 4\nf 13 14 6 5\nf 14 15 7 6\nf 15 16 8 7\nf 16 9 1 8\n"),
      "a.obj");
  const slice::Sliced s = sliced(u);
  CHECK(s.defects.empty());
  CHECK(s.facts.closed);
  CHECK(geometry::area_mm2(s.layers[0]) == Approx(100.0));
  CHECK(geometry::area_mm2(s.layers[9]) == Approx(60.0));
}

TEST_CASE("Coordinates of a map keep their digits in text, and a file that has lost them says how many") {
  mb::Bytes far = mb::obj(cube());
  std::string text(reinterpret_cast<const char*>(far.data()), far.size()), moved;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    std::string line = text.substr(at, end - at);
    if (line.starts_with("v ")) {
      double x = 0, y = 0, z = 0;
      std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z);
      char out[80];
      std::snprintf(out, sizeof out, "v %.3f %.3f %.3f", 3.33 * x + 500123.27, 3.33 * y + 4512345.37,
                    z + 300.13);
      line = out;
    }
    moved += line + "\n";
    at = end + 1;
  }
  const slice::Sliced s = sliced(read_foreign(moved, "a.obj"));
  CHECK(geometry::area_mm2(s.layers[0]) == Approx(33.3 * 33.3).epsilon(1e-9));
  CHECK(s.defects.empty());
  SampleMesh coarse = cube();
  for (auto& v : coarse.vertices) v[1] += 4'512'345.0f;
  const slice::Sliced lost = sliced(read_foreign(mb::binary_stl(coarse), "a.stl"));
  REQUIRE(lost.defects.size() == 1);
  CHECK(lost.defects[0].kind == slice::DefectKind::kCoarse);
  CHECK(lost.defects[0].size_mm == 0.5);
}

}  // namespace firn::test
