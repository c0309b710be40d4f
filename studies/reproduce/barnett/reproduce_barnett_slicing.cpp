// Computes chapter 3: Tables 3-2 to 3-5 and Figs. 3-2, 3-7. The statue's mesh is not published and the
// thesis's times are of its own machine, so these are not identifiable; sizes of binary files are.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "core/geometry/clipper.h"
#include "core/geometry/planar.h"
#include "core/slice/support/scaffold.h"
#include "files/mesh/mesh_file.h"
#include "files/mesh/sample_mesh.h"
#include "print/prepare/slice_job.h"
#include "report/paths/slice_pictures.h"
#include "runtime/thread_pool.h"
#include "studies/reproduce/reproduce.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

std::string slicing_id(const std::string& name) { return "barnett.slicing." + name; }

double cpu_s() { return double(std::clock()) / CLOCKS_PER_SEC; }
template <class Body>
double seconds_of(const Body& body) {
  const double begin = cpu_s();
  body();
  return cpu_s() - begin;
}

constexpr const char* kTable32 = "p. 43, Table 3-2";
constexpr const char* kOwnTimes =
    "a time of the thesis's computer and Matlab programs, of a mesh that is not published";
constexpr const char* kOwnMesh = "a count of the thesis's mesh, which is not published";
constexpr const char* kDigits =
    "the size of a text depends on the digits of its numbers, which the thesis does not print";

// The thesis's figures for the coarse and the fine mesh of its statue.
struct Thesis {
  const char* name;
  std::uint32_t around, up;
  double facets, polymerge_s, segmerge_s, segmerge2_s, segments, filtered;
  double part_s, scaffold_s;                                    // Table 3-4, BUFFERF
  double scaffold_segments;                                     // Table 3-4; the part's are `filtered`
  double old_part_s, old_scaffold_s;                            // BUFFERM, revision 1.5.4.9
  double new_part_s, new_scaffold_s;                            // BUFFERM, revision 1.5.4.13
  double read_s, slice_s, rpscaf_s, bounds_s, fill_s, total_s;  // Table 3-5
};
constexpr Thesis kCoarse{"coarse", 63,    31,    3906,  3.3,    0.8, 0.5, 118604, 112044, 23.8,  60.3,
                         283541,   163.8, 479.1, 285.1, 1244.2, 0.1, 1.8, 247.7,  84.1,   668.8, 1002.5};
constexpr Thesis kFine{"fine", 1000,  500,    1e6,    521.8,  25.9, 7.0,  1739712, 302332, 64.6,  127.4,
                       555417, 667.4, 1271.4, 1339.7, 4196.8, 0.5,  12.7, 243.9,   192.0,  832.2, 1281.3};

void format_rows(Reproduction& to, const SampleMesh& mesh) {
  struct Row {
    MeshFormat format;
    const char *file, *name;
    double mb, import_s;
    const char* quote;  ///< Table 3-2
  };
  constexpr Row kRows[] = {
      {MeshFormat::kBinaryPly, "a.ply", "binary-ply", 18.1, 0.5, "binary PLY two FREAD statements 18.1 0.5"},
      {MeshFormat::kAsciiPly, "a.ply", "ascii-ply", 34.9, 5.3, "ASCII PLY two FSCANF statements 34.9 5.3"},
      {MeshFormat::kBinaryStl, "a.stl", "binary-stl", 47.6, 0.7, "binary STL one FREAD statement 47.6 0.7"},
      {MeshFormat::kAsciiStl, "a.stl", "ascii-stl", 257.8, 28.6,
       "ASCII STL one FSCANF statement 257.8 28.6"}};
  const double million = 1e6 / double(mesh.triangles.size());
  const bool indexed =
      mesh.vertices.size() < mesh.triangles.size();  // half as many corners as facets, if it is closed
  bool same = true;
  for (const Row& r : kRows) {
    const std::string text = mesh_bytes(mesh, r.format);
    const auto bytes = std::as_bytes(std::span(text));
    const double mb = double(text.size()) * million / (1 << 20);
    ReproduceRow size(slicing_id(std::string("size-") + r.name),
                      std::string("Table 3-2: size of a million facets, ") + r.name, "MiB", mb, 1);
    size.prints(r.mb, kTable32, r.quote);
    if (r.format == MeshFormat::kBinaryStl || (r.format == MeshFormat::kBinaryPly && indexed))
      size.within(0.3).arithmetic();
    else
      size.not_identifiable(kDigits);
    to.row(std::move(size));
    MeshData data;
    double sum = 0.0;  // every corner is looked at: binary STL is not copied
    const double took = seconds_of([&] {
      data = read_mesh(bytes, r.file);
      const slice::FacetView facets = data.facets();
      for (std::size_t n = 0; n < facets.size(); ++n)
        for (const slice::Corner& c : facets.facet(n)) sum += double(c[0]) + double(c[1]) + double(c[2]);
    });
    same = same && std::isfinite(sum);
    to.row(ReproduceRow(slicing_id(std::string("import-") + r.name),
                        std::string("Table 3-2: import, ") + r.name +
                            fmt::format(", {} facets (thesis: a million)", mesh.triangles.size()),
                        "s", took, 3)
               .prints(r.import_s, kTable32, r.quote)
               .not_identifiable(kOwnTimes));
    const slice::FacetView view = data.facets();
    same = same && view.size() == mesh.triangles.size();
    for (std::size_t n = 0; same && n < view.size(); ++n)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t a = 0; a < 3; ++a)
          same = same && std::abs(double(view.facet(n)[c][a]) + view.origin[a] -
                                  double(mesh.vertices[mesh.triangles[n][c]][a])) <= 1e-4;
  }
  if (!same) throw std::runtime_error("the formats of one mesh do not give the same facets");
}

// The thesis's slow techniques, in C++: one reading call for each facet, or for each word.
void loop_rows(Reproduction& to, const SampleMesh& mesh) {
  struct Facet {
    float numbers[12];
    std::uint16_t attribute;
  };
  const auto opened = [](const std::string& text) {
    std::FILE* file = fmemopen(const_cast<char*>(text.data()), text.size(), "r");
    if (!file) throw std::runtime_error("fmemopen failed");
    return std::unique_ptr<std::FILE, int (*)(std::FILE*)>(file, &std::fclose);
  };
  const std::string facets = fmt::format(", {} facets (thesis: a million)", mesh.triangles.size());
  const auto row = [&](const char* name, const char* what, double thesis_s, const char* quote,
                       std::size_t read, double took) {
    if (read != mesh.triangles.size())
      throw std::runtime_error(
          fmt::format("{}: {} of {} facets were read", what, read, mesh.triangles.size()));
    to.row(ReproduceRow(slicing_id(std::string("import-") + name),
                        std::string("Table 3-2: import, ") + what + facets, "s", took, 3)
               .prints(thesis_s, kTable32, quote)
               .not_identifiable(kOwnTimes));
  };
  std::size_t read = 0;
  const std::string binary = mesh_bytes(mesh, MeshFormat::kBinaryStl),
                    text = mesh_bytes(mesh, MeshFormat::kAsciiStl);
  const double binary_s = seconds_of([&] {
    const auto file = opened(binary);
    std::vector<Facet> list;
    Facet f{};
    std::fseek(file.get(), 84, SEEK_SET);
    while (std::fread(f.numbers, sizeof f.numbers, 1, file.get()) == 1 &&
           std::fread(&f.attribute, 2, 1, file.get()) == 1)
      list.push_back(f);
    read = list.size();
  });
  row("binary-stl-loop", "binary-stl by a loop with a reading call per facet", 21.6,
      "binary STL FOR loop with one FREAD statement 47.6 21.6", read, binary_s);
  const double text_s = seconds_of([&] {
    const auto file = opened(text);
    std::vector<std::array<float, 3>> corners;
    std::array<float, 3> c{};
    char word[80];
    while (std::fscanf(file.get(), "%79s", word) == 1)
      if (std::string_view(word) == "vertex" && std::fscanf(file.get(), "%f %f %f", &c[0], &c[1], &c[2]) == 3)
        corners.push_back(c);
    read = corners.size() / 3;
  });
  row("ascii-stl-loop", "ascii-stl by a loop with a reading call per word", 104.8,
      "ASCII STL WHILE loop with multiple FSCANF statements 257.8 104.8", read, text_s);
}

// All stages of one mesh, each timed. The concentric fill runs from the outline, so bounds are timed without
// it.
struct Stages {
  double read_s = 0, slice_s = 0, link_s = 0, scaffold_s = 0, part_bounds_s = 0, scaffold_bounds_s = 0,
         all_paths_s = 0;
  double part_clipper_s = 0, scaffold_clipper_s = 0;  // the same outlines offset by Clipper 1
  slice::SliceCounts counts;
  slice::MeshFacts facts;
  std::vector<slice::LayerRegions> layers;
  std::size_t scaffold_points = 0, paths = 0;
  double metres = 0, area_volume_mm3 = 0, filtered = 0;
};

std::vector<slice::LayerPaths> plan_all(const std::vector<slice::LayerRegions>& layers,
                                        const slice::PathOptions& options, const ParallelFor& parallel) {
  std::vector<slice::LayerPaths> out(layers.size());
  parallel(int(layers.size()),
           [&](int n) { out[std::size_t(n)] = slice::plan_layer(layers[std::size_t(n)], options); });
  return out;
}

Stages run_stages(const SampleMesh& mesh, const ParallelFor& parallel) {
  Stages s;
  SliceSettings settings;
  const std::string text = mesh_bytes(mesh, MeshFormat::kBinaryPly);
  MeshData data;
  s.read_s = seconds_of([&] { data = read_mesh(std::as_bytes(std::span(text)), "statue.ply"); });
  slice::Sliced sliced;
  s.slice_s = seconds_of([&] {
    const slice::FacetView facets = data.facets();
    const slice::Affine affine = slice::place(facets, placement(settings, 0), parallel);
    slice::Segments segments = slice::intersect(
        facets, affine, slice::layer_planes(settings.contour.layer_height_mm, affine.high.z), parallel);
    const slice::MeshFacts facts = segments.facts;
    std::vector<slice::Contours> contours;
    s.link_s =
        seconds_of([&] { contours = slice::link(std::move(segments), contour_options(settings), parallel); });
    sliced = slice::regions(std::move(contours), facts, contour_options(settings), parallel);
  });
  s.counts = sliced.counts;
  s.facts = sliced.facts;
  for (const geometry::Region& r : sliced.layers)
    s.area_volume_mm3 += geometry::area_mm2(r) * settings.contour.layer_height_mm;

  slice::SliceOptions spaced = settings.contour;  // PATHFILTER alone, as in Table 3-3
  spaced.chord_tolerance_mm = 0.0;
  spaced.min_spacing_mm = 0.4;
  s.filtered =
      double(slice::slice(data.facets(), placement(settings, 0), spaced, parallel).counts.kept_points);

  const slice::PathOptions options = path_options(settings);
  const auto height = std::int32_t(std::lround(settings.contour.layer_height_mm * geometry::kUnitsPerMm));
  std::vector<geometry::Region> scaffold;
  s.scaffold_s = seconds_of([&] {
    scaffold =
        slice::scaffold_regions(sliced.layers, height, options.support, options.chord_tolerance_mm, parallel);
  });
  for (std::size_t n = 0; n < sliced.layers.size(); ++n) {
    s.scaffold_points += scaffold[n].points.size();
    s.layers.push_back({std::int32_t(n) + 1,
                        std::int32_t(n + 1) * height,
                        height,
                        {std::move(sliced.layers[n]), std::move(scaffold[n])},
                        std::move(sliced.contours[n]),
                        contour_options(settings).chord_tolerance_mm,
                        true});
  }
  slice::PathOptions bounds = options;
  bounds.part.pattern = bounds.scaffold.pattern = slice::FillPattern::kNone;
  const auto only = [&](std::size_t material) {
    std::vector<slice::LayerRegions> some = s.layers;
    for (slice::LayerRegions& l : some) l.by_material[1 - material].clear();
    return seconds_of([&] { plan_all(some, bounds, parallel); });
  };
  s.part_bounds_s = only(0);
  s.scaffold_bounds_s = only(1);
  const auto by_clipper = [&](std::size_t material, double offset_mm) {
    return seconds_of([&] {
      parallel(int(s.layers.size()), [&](int n) {
        geometry::clipper_offset(s.layers[std::size_t(n)].by_material[material], offset_mm,
                                 options.chord_tolerance_mm);
      });
    });
  };
  s.part_clipper_s = by_clipper(0, options.part.first_offset_mm);
  s.scaffold_clipper_s = by_clipper(1, options.scaffold.first_offset_mm);
  std::vector<slice::LayerPaths> paths;
  s.all_paths_s = seconds_of([&] { paths = plan_all(s.layers, options, parallel); });
  for (const slice::LayerPaths& l : paths) {
    s.paths += l.lines.size();
    for (const slice::MaterialUse& u : slice::material_use(l)) s.metres += u.length_mm / 1000.0;
  }
  return s;
}

void stage_rows(Reproduction& to, const Thesis& t, const Stages& s, std::size_t facets) {
  const std::string mesh =
      fmt::format(", {} mesh (thesis: {:.0f} facets; ours: {})", t.name, t.facets, facets);
  struct Source {
    const char *place, *quote;
  };
  constexpr Source kTable33{"p. 46, Table 3-3",
                            "3906 1 000 000 3.3 521.8 0.8 25.9 0.5 7.0 118 604 1 739 712 112 044 302 332"};
  constexpr Source kPart{"p. 56, Table 3-4",
                         "Part 3906 1 000 000 112 044 302 332 163.8 667.4 285.1 1339.7 23.8 64.6"};
  constexpr Source kScaffold{
      "p. 56, Table 3-4",
      "Scaffolding 3906 1 000 000 283541 555417 $479.1 \\\\ 1271.4$ 1244.2 4196.8 60.3 127.4"};
  const auto row = [&](const std::string& name, const std::string& what, const Source& source, double thesis,
                       double ours) {  // seconds, or a count
    const bool count = what.find("segments") != std::string::npos;
    to.row(ReproduceRow(slicing_id(std::string(t.name) + "-" + name), what + mesh, count ? "" : "s", ours,
                        count ? 0 : 3)
               .prints(thesis, source.place, source.quote)
               .not_identifiable(count ? kOwnMesh : kOwnTimes));
  };
  row("segments", "Table 3-3: segments before PATHFILTER", kTable33, t.segments, double(s.counts.segments));
  row("filtered", "Table 3-3: segments after PATHFILTER, spacing 0.4 mm", kTable33, t.filtered, s.filtered);
  row("link", "Table 3-3: linking, SEGMERGE2", kTable33, t.segmerge2_s, s.link_s);
  row("link-segmerge", "Table 3-3: linking, SEGMERGE (accepts non-manifold edges, as ours does)", kTable33,
      t.segmerge_s, s.link_s);
  row("link-polymerge", "Table 3-3: linking, POLYMERGE", kTable33, t.polymerge_s, s.link_s);
  row("offset-part", "Table 3-4: offset of the part's outline, BUFFERF", kPart, t.part_s, s.part_bounds_s);
  row("offset-scaffold", "Table 3-4: offset of the scaffold's outline, BUFFERF", kScaffold, t.scaffold_s,
      s.scaffold_bounds_s);
  row("scaffold-segments", "Table 3-4: segments of the scaffold's outlines", kScaffold, t.scaffold_segments,
      double(s.scaffold_points));
  const std::string clipper = " (ours: Clipper 1, every outline offset on its own)";
  row("bufferm-part", "Table 3-4: offset of the part's outline, BUFFERM 1.5.4.9" + clipper, kPart,
      t.old_part_s, s.part_clipper_s);
  row("bufferm-scaffold", "Table 3-4: offset of the scaffold's outline, BUFFERM 1.5.4.9" + clipper, kScaffold,
      t.old_scaffold_s, s.scaffold_clipper_s);
  row("bufferm-new-part", "Table 3-4: offset of the part's outline, BUFFERM 1.5.4.13" + clipper, kPart,
      t.new_part_s, s.part_clipper_s);
  row("bufferm-new-scaffold", "Table 3-4: offset of the scaffold's outline, BUFFERM 1.5.4.13" + clipper,
      kScaffold, t.new_scaffold_s, s.scaffold_clipper_s);
  const double bounds = s.part_bounds_s + s.scaffold_bounds_s, fill = std::max(0.0, s.all_paths_s - bounds);
  constexpr const char* kTable35 = "p. 58, Table 3-5";
  row("read", "Table 3-5: FACETREAD", {kTable35, "FACETREAD 0.1 0.5"}, t.read_s, s.read_s);
  row("slice", "Table 3-5: FACETSLICE", {kTable35, "FACETSLICE 1.8 12.7"}, t.slice_s, s.slice_s);
  row("scaffold", "Table 3-5: RPSCAF", {kTable35, "RPSCAF 247.7 243.9"}, t.rpscaf_s, s.scaffold_s);
  row("bounds", "Table 3-5: BUFFERF (bounds)", {kTable35, "BUFFERF (bounds) 84.1 192.0"}, t.bounds_s, bounds);
  row("fill", "Table 3-5: BUFFERF (fill), with seams and order", {kTable35, "BUFFERF (fill) 668.8 832.2"},
      t.fill_s, fill);
  row("total", "Table 3-5: total", {kTable35, "total 1002.5 1281.3"}, t.total_s,
      s.read_s + s.slice_s + s.scaffold_s + s.all_paths_s);
  const std::string front = std::string(t.name) + "-";
  to.beside({slicing_id(front + "layers"), "layers of 0.25 mm" + mesh, "", double(s.layers.size()), 0});
  to.beside({slicing_id(front + "metres"), "length of all paths" + mesh, "m", s.metres, 1});
  to.beside({slicing_id(front + "paths"), "paths" + mesh, "", double(s.paths), 0});
  if (s.facts.closed)
    to.beside(
        {slicing_id(front + "volume"),
         "volume of all contours against the mesh's (divergence theorem), chord tolerance 0.05 mm" + mesh,
         "%", 100.0 * std::abs(s.area_volume_mm3 / s.facts.volume_mm3 - 1.0), 4});
}

void pictures(Reproduction& to, const Stages& s) {
  if (s.layers.size() < 100) return;
  const slice::LayerRegions& layer = s.layers[99];  // 25 mm from the substrate
  SliceSettings settings;
  report::PicturedLayer concentric{layer, slice::plan_layer(layer, path_options(settings))};
  settings.part.fill = settings.scaffold.fill = "zigzag";
  report::PicturedLayer zigzag{layer, slice::plan_layer(layer, path_options(settings))};
  settings.part.fill = settings.scaffold.fill = "none";
  report::PicturedLayer outlines{layer, slice::plan_layer(layer, path_options(settings))};
  to.picture({"fig-3-2", "Fig. 3-2: part and scaffold, 25 mm from the substrate, with their first paths",
              report::layers_svg({&outlines, 1})});
  to.picture({"fig-3-7a", "Fig. 3-7(a): zig-zag fill of the same layer", report::layers_svg({&zigzag, 1})});
  to.picture({"fig-3-7b", "Fig. 3-7(b): concentric fill", report::layers_svg({&concentric, 1})});
}

SampleMesh mesh_of(const std::string& file) {
  const MeshFile read(file);
  SampleMesh mesh{read.data().vertices, read.data().triangles};
  const slice::FacetView facets = read.facets();
  for (std::size_t n = mesh.triangles.size(); n < facets.size(); ++n) {  // a soup
    const auto first = std::uint32_t(mesh.vertices.size());
    for (const slice::Corner& c : facets.facet(n)) mesh.vertices.push_back(c);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace

void reproduce_barnett_slicing(Reproduction& to) {
  to.note(
      "The thesis's mesh of the James McGill statue is not published. Ours is a robed figure made in code, "
      "as high (691 layers of 0.25 mm) and of as "
      "many facets; layers, segments, metres and paths are given so that the work can be compared. Times are "
      "CPU seconds on this machine's threads "
      "(chord tolerance 0.05 mm), the thesis's are of Matlab on a Core i7-2720QM of 2011: they are shown, "
      "not judged.");
  const ParallelFor parallel = parallel_on(to.threads());
  const bool quick = to.quick();
  to.progress(0.0, "mesh");
  const SampleMesh fine = !to.mesh().empty() ? mesh_of(to.mesh())
                          : quick            ? statue(120, 60)
                                             : statue(kFine.around, kFine.up);
  format_rows(to, fine);
  loop_rows(to, fine);
  to.progress(0.4, "coarse mesh");
  const SampleMesh coarse = statue(kCoarse.around, kCoarse.up);
  stage_rows(to, kCoarse, run_stages(coarse, parallel), coarse.triangles.size());
  to.progress(0.6, "fine mesh");
  const Stages s = run_stages(fine, parallel);
  stage_rows(to, kFine, s, fine.triangles.size());
  pictures(to, s);
}

}  // namespace firn
