// firn slice end to end: a gear in, paths, G-code, pictures and a report out.
#include "cli/slice_command.h"

#include <catch2/catch.hpp>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "config/error.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/path/layer_file.h"
#include "files/path/path_file.h"
#include "files/record/part_file.h"
#include "files/usage_error.h"
#include "print/prepare/gcode.h"
#include "print/prepare/slice_job.h"
#include "print/prepare/slice_report.h"
#include "tests/support/mesh_samples.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
namespace fs = std::filesystem;
namespace mb = firn::test::mesh_bytes;

namespace {

fs::path scratch(const std::string& name) {
  const fs::path f = fs::path(FIRN_BINARY_DIR) / "tests" / "slice_command";
  fs::create_directories(f);
  return f / name;
}

std::string write_mesh(const std::string& name, const std::vector<std::byte>& bytes) {
  const fs::path f = scratch(name);
  std::ofstream(f, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  return f.string();
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A gear whose upper half is wider than its lower one: something to support.
SampleMesh mushroom() {
  SampleMesh m = gear(8, 3.0f, 10.0, 8.0), cap = gear(8, 3.0f, 16.0, 14.0);
  const auto base = std::uint32_t(m.vertices.size());
  for (auto v : cap.vertices) m.vertices.push_back({v[0], v[1], v[2] + 2.5f});
  for (auto t : cap.triangles) m.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return m;
}

SliceCommandOptions run_options(const std::string& name) {
  SliceCommandOptions o;
  o.meshes = {write_mesh(name + ".stl", mb::binary_stl(mushroom()))};
  o.output = scratch(name + ".paths").string();
  o.threads = 1;
  return o;
}

// Holds the sums that a reader of G-code computes: lengths of extruding moves and extruded lengths, by tool.
struct GcodeSums {
  std::map<int, double> length_mm, e;
};
GcodeSums read_gcode(const std::string& text) {
  GcodeSums sums;
  std::istringstream in(text);
  double x = 0, y = 0;
  int tool = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == ';') continue;
    if (line[0] == 'T') tool = std::stoi(line.substr(1));
    double to_x = x, to_y = y, e = 0;
    std::istringstream words(line);
    for (std::string w; words >> w;) {
      if (w[0] == ';') break;
      if (w[0] == 'X') to_x = std::stod(w.substr(1));
      if (w[0] == 'Y') to_y = std::stod(w.substr(1));
      if (w[0] == 'E') e = std::stod(w.substr(1));
    }
    if (line.starts_with("G1") && e > 0) {
      sums.length_mm[tool] += std::hypot(to_x - x, to_y - y);
      sums.e[tool] += e;
    }
    x = to_x;
    y = to_y;
  }
  return sums;
}

const SliceProgress kQuiet = [](double, const std::string&) {};

}  // namespace

TEST_CASE("firn slice writes paths that read back to the totals it reports") {
  const SliceCommandOptions o = run_options("totals");
  REQUIRE(run_slice(o) == kOk);
  LayerReader reader{fs::path(o.output)};
  CHECK(reader.head().layers == 22);  // 5.5 mm of 0.25 mm
  CHECK(reader.head().materials.size() == 2);
  double length = 0;
  std::size_t layers = 0;
  while (const auto layer = reader.next()) {
    ++layers;
    CHECK(layer->z == std::int32_t(layers) * 2'500);
    for (const slice::MaterialUse& u : slice::material_use(*layer)) length += u.length_mm;
  }
  CHECK(layers == 22);
  REQUIRE(reader.totals().use.size() == 2);
  CHECK(reader.totals().use[0].length_mm + reader.totals().use[1].length_mm == Approx(length));
  // The settings stand in the file and give the same bytes again.
  const fs::path settings = scratch("again.toml");
  std::ofstream(settings) << reader.head().settings;
  SliceCommandOptions again = o;
  again.config = settings.string();
  again.output = scratch("again.paths").string();
  again.threads = 2;
  REQUIRE(run_slice(again) == kOk);
  CHECK(text_of(again.output) == text_of(o.output));
}

TEST_CASE(
    "Beads read back from the path file, overlaps taken off, have the volume of what they fill, layer by "
    "layer") {
  const SliceCommandOptions o = run_options("read_back");
  REQUIRE(run_slice(o) == kOk);
  const SliceSettings s = load_slice_settings({}, {});
  const SlicedJob job = slice_meshes({fs::path(o.meshes[0])}, s, serially, kQuiet);
  LayerReader reader{fs::path(o.output)};
  double swept_mm3[2] = {}, wanted_mm3[2] = {};
  for (const slice::LayerRegions& regions : job.layers) {
    const auto layer = reader.next();
    REQUIRE(layer.has_value());
    const std::vector<slice::Coverage> covered = slice::coverage(regions, *layer, path_options(s), 0.05);
    REQUIRE(covered.size() == 2);
    for (std::size_t m = 0; m < 2; ++m) {
      INFO("layer " << regions.layer << ", material " << m);
      const slice::Coverage& c = covered[m];
      const double height_mm = layer->height * geometry::kMmPerUnit;
      swept_mm3[m] += c.swept_mm2 * height_mm;
      wanted_mm3[m] += c.wanted_mm2 * height_mm;
      CHECK(c.gap_mm2 <= 0.05 * c.wanted_mm2);
      CHECK(c.beyond_mm2 <= 0.05 * c.wanted_mm2);
      CHECK(c.swept_mm2 == Approx(c.wanted_mm2).epsilon(0.05));
    }
    // The deposited volume is that of the covered area and of the area covered twice: width x height x
    // length, but for round ends.
    const auto use = slice::material_use(*layer);
    for (std::size_t m = 0; m < use.size(); ++m)
      CHECK(use[m].volume_mm3 / (layer->height * geometry::kMmPerUnit) <=
            1.03 * (covered[m].swept_mm2 + 2.0 * covered[m].overlap_mm2) + 1.0);
  }
  CHECK_FALSE(reader.next().has_value());
  for (int m = 0; m < 2; ++m) {
    INFO("material " << m << ": " << swept_mm3[m] << " of " << wanted_mm3[m] << " mm^3");
    CHECK(swept_mm3[m] == Approx(wanted_mm3[m]).epsilon(0.03));
  }
}

TEST_CASE("Every mesh format gives the same path file") {
  const SampleMesh m = mushroom();
  std::string first;
  for (const auto& [name, bytes] : {std::pair{"f.stl", mb::binary_stl(m)},
                                    {"f-ascii.stl", mb::ascii_stl(m)},
                                    {"f.ply", mb::binary_ply(m, true)},
                                    {"f-ascii.ply", mb::ascii_ply(m)},
                                    {"f.obj", mb::obj(m)},
                                    {"f.3mf", mb::threemf(m)}}) {
    SliceCommandOptions o;
    o.meshes = {write_mesh(name, bytes)};
    o.output = scratch("format.paths").string();
    REQUIRE(run_slice(o) == kOk);
    if (first.empty()) first = text_of(o.output);
    INFO(name);
    CHECK(text_of(o.output) == first);
  }
}

TEST_CASE("G-code read back has the lengths and volumes of the path file") {
  SliceCommandOptions o = run_options("gcode");
  o.gcode = scratch("gcode.gcode").string();
  o.overrides = {"gcode.x_mm=-3.5", "gcode.start=G28|T0"};
  REQUIRE(run_slice(o) == kOk);
  LayerReader reader{fs::path(o.output)};
  while (reader.next()) {
  }
  const std::string text = text_of(o.gcode);
  const GcodeSums sums = read_gcode(text);
  const double filament_mm2 = 1.75 * 1.75 * M_PI / 4;
  REQUIRE(sums.length_mm.size() == 2);
  for (const auto& [tool, length] : sums.length_mm) {
    const slice::MaterialUse& use = reader.totals().use[std::size_t(tool)];
    CHECK(length == Approx(use.length_mm).epsilon(1e-6));
    CHECK(sums.e.at(tool) * filament_mm2 == Approx(use.volume_mm3).epsilon(1e-4));
  }
  CHECK(text.find("G28\nT0\n") != std::string::npos);
  CHECK(text.ends_with("; end\n"));
  CHECK(text.find("nan") == std::string::npos);
}

TEST_CASE("One layer goes into JSON that firn plan reads, SVG and PNG") {
  SliceCommandOptions o = run_options("picture");
  o.layers = {5};
  o.layer_json = scratch("picture.json").string();
  o.svg = scratch("picture.svg").string();
  o.png = scratch("picture.png").string();
  REQUIRE(run_slice(o) == kOk);
  std::size_t in_file = 0, in_json = 0;
  LayerReader reader{fs::path(o.output)};
  while (const auto layer = reader.next())
    if (layer->layer == 5) in_file = layer->lines.size();
  read_paths(o.layer_json, [&](InputPath&& p) {
    ++in_json;
    CHECK(p.path.layer == 5);
    CHECK(p.tool == (p.path.material == 0 ? "water" : "scaffold"));
  });
  CHECK(in_json == in_file);
  const std::string svg = text_of(o.svg), png = text_of(o.png);
  CHECK(svg.starts_with("<svg "));
  CHECK(std::size_t(std::count(svg.begin(), svg.end(), 'M')) >= in_file);
  CHECK(png.starts_with("\x89PNG"));
  o.layers = {1, 5, 20};  // a contact sheet
  o.layer_json.clear();
  REQUIRE(run_slice(o) == kOk);
  CHECK(text_of(o.svg).find("layer 20, 5 mm") != std::string::npos);
}

TEST_CASE("Two parts of two materials: the first has its way, and both are filled") {
  const SampleMesh a = gear(8, 2.0f), b = prism(4, 2.0f, 20.0f, 20.0f, [](std::uint32_t) { return 25.0; });
  const std::vector<fs::path> files{write_mesh("gear.stl", mb::binary_stl(a)),
                                    write_mesh("block.ply", mb::binary_ply(b, false))};
  const SliceSettings s =
      parse_slice_settings("[mesh]\nmaterial = [0, 2]\n[support]\nkind = \"none\"\n", "s.toml");
  SlicedJob job = slice_meshes(files, s, serially, kQuiet);
  REQUIRE(job.layers.size() == 8);
  REQUIRE(job.layers[3].by_material.size() == 3);
  const auto area = [](const geometry::Region& r) {
    double sum = 0;
    for (std::size_t k = 0; k < r.size(); ++k)
      for (std::size_t n = 0; n < r[k].size(); ++n) {
        const geometry::Point p = r[k][n], q = r[k][(n + 1) % r[k].size()];
        sum += 0.5 * (double(p.x) * q.y - double(q.x) * p.y);
      }
    return sum * geometry::kMmPerUnit * geometry::kMmPerUnit;
  };
  const double gear_mm2 = area(job.layers[3].by_material[0]), rest_mm2 = area(job.layers[3].by_material[2]);
  CHECK(gear_mm2 == Approx(job.parts[0].facts.volume_mm3 / 2.0).epsilon(1e-3));
  CHECK(gear_mm2 + rest_mm2 == Approx(2 * 25.0 * 25.0).epsilon(1e-3));  // the gear lies within the square
  SliceSums sums;
  plan_layers(job, s, serially, kQuiet, {}, [&](PlannedLayer&& l) { sums.add(l); });
  REQUIRE(sums.totals.use.size() == 3);
  CHECK(sums.totals.use[0].length_mm > 0);
  CHECK(sums.totals.use[1].length_mm == 0);
  CHECK(sums.totals.use[2].length_mm > 0);
}

TEST_CASE("Of a part with many layers the texts of 32 at most are in memory at once") {
  const SliceSettings s = parse_slice_settings("[layer]\nheight_mm = 0.01\n", "s.toml");
  SlicedJob job = slice_meshes({write_mesh("tall.stl", mb::binary_stl(gear(8, 2.0f)))}, s, serially, kQuiet);
  int made = 0, handed_on = 0, most = 0;
  const auto text = [&](const slice::LayerPaths&) {
    most = std::max(most, ++made - handed_on);
    return std::string();
  };
  plan_layers(job, s, serially, kQuiet, {false, text},
              [&](PlannedLayer&& l) { handed_on += l.paths.layer == handed_on + 1; });
  REQUIRE(handed_on == 200);
  CHECK(most <= 32);
}

TEST_CASE("The report is JSON with stages, layers, lengths, volumes and defects by layer and place") {
  SampleMesh holed = gear(8, 2.0f);
  holed.triangles.erase(holed.triangles.begin());  // a hole in the side
  const std::vector<fs::path> files{write_mesh("holed.stl", mb::binary_stl(holed))};
  const SliceSettings s = parse_slice_settings("[coverage]\non = 1\npitch_mm = 0.2\n", "s.toml");
  SlicedJob job = slice_meshes(files, s, serially, kQuiet);
  SliceSums sums;
  plan_layers(job, s, serially, kQuiet, {}, [&](PlannedLayer&& l) { sums.add(l); });
  const auto j = nlohmann::json::parse(slice_json(job, s, sums, {{"a.paths", 7}}, 1));
  CHECK(j["layers"] == 8);
  CHECK(j["parts"][0]["closed"] == false);
  CHECK(j["parts"][0]["format"] == "binary STL");
  CHECK(j["materials"][0]["volume_mm3"].get<double>() > 0);
  CHECK(j["coverage"].size() == 8);
  CHECK(j["stages"].back()["stage"] == "total");
  CHECK(j["files"][0]["bytes"] == 7);
  bool with_place = false;
  for (const auto& d : j["defects"]) with_place = with_place || (d.contains("layer") && d.contains("at_mm"));
  CHECK(with_place);
  CHECK(slice_text(job, s, sums).find("not closed") != std::string::npos);
}

TEST_CASE("A part that no layer's plane meets is told of, with its heights, in text and JSON") {
  const auto report = [](const std::vector<SampleMesh>& meshes, bool json) {
    std::vector<fs::path> files;
    for (const SampleMesh& m : meshes)
      files.push_back(write_mesh("thin" + std::to_string(files.size()) + ".stl", mb::binary_stl(m)));
    const SliceSettings s = parse_slice_settings("", "s.toml");
    SlicedJob job = slice_meshes(files, s, serially, kQuiet);
    SliceSums sums;
    plan_layers(job, s, serially, kQuiet, {}, [&](PlannedLayer&& l) { sums.add(l); });
    return json ? slice_json(job, s, sums, {}, 1) : slice_text(job, s, sums);
  };
  const SampleMesh thin = gear(8, 0.1f), thick = gear(8, 2.0f);
  CHECK_THAT(report({thin}, false),
             Contains("warning: ") &&
                 Contains("thin0.stl: in no layer: it reaches from z = 0 to 0.1 mm (0.1 mm high)") &&
                 Contains("0.125 + n x 0.25 mm"));
  const auto j = nlohmann::json::parse(report({thick, thin}, true));
  REQUIRE(j["warnings"].size() == 1);
  CHECK_THAT(j["warnings"][0].get<std::string>(), Contains("thin1.stl: in no layer"));
  CHECK(nlohmann::json::parse(report({thick}, true))["warnings"].empty());
}

TEST_CASE("firn slice refuses what it cannot do, and leaves nothing behind") {
  SliceCommandOptions o = run_options("refused");
  fs::remove(o.output);
  const auto refused = [](const SliceCommandOptions& options, const std::string& why) {
    CHECK_THROWS_WITH(run_slice(options), Contains(why));
  };
  const auto with = [&](auto change) {
    SliceCommandOptions c = o;
    change(c);
    return c;
  };
  refused(with([](auto& c) { c.layers = {3}; }), "--layer needs --svg");
  refused(with([](auto& c) { c.svg = "x.svg"; }), "need --layer K");
  refused(with([](auto& c) {
            c.layers = {99};
            c.svg = "x.svg";
          }),
          "--layer 99: the job has 22 layers");
  refused(with([](auto& c) { c.support = "ful"; }), "one of full, overhang, none");
  refused(with([](auto& c) { c.tolerance_mm = -2; }), "contour.tolerance_mm");
  refused(with([](auto& c) { c.tolerance_mm = -1; }), "contour.tolerance_mm");
  refused(with([](auto& c) { c.overrides = {"mesh.scale=[1e4,1e4,1e4]"}; }), "beyond the limit of 107374 mm");
  refused(with([](auto& c) { c.meshes = {"no/such.stl"}; }), "no/such.stl: no such file");
  refused(with([](auto& c) { c.config = "no/such.toml"; }), "no/such.toml");
  refused(with([](auto& c) { c.output = "no/such/folder/x.paths"; }), "no/such/folder");
  refused(with([](auto& c) { c.output = c.meshes[0]; }), "would take the place of");
  refused(with([](auto& c) { c.gcode = c.output; }), "would take the place of");
  CHECK_FALSE(fs::exists(o.output));
}

TEST_CASE("An output replaces regular files only, and what a link points to, not the link") {
  SliceCommandOptions o = run_options("target");
  const fs::path folder = fs::path(o.output).parent_path(), link = folder / "link.paths";
  fs::remove(link);
  fs::remove(o.output);
  for (const auto& [member, ending] :
       {std::pair(&SliceCommandOptions::output, ".paths"), std::pair(&SliceCommandOptions::gcode, ".nc"),
        std::pair(&SliceCommandOptions::svg, ".svg")}) {
    const fs::path pipe = folder / (std::string("pipe") + ending),
                   taken = folder / (std::string("folder") + ending);
    fs::remove(pipe);
    fs::create_directory(taken);
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    SliceCommandOptions c = o;
    c.output = "";
    c.*member = pipe.string();
    if (!c.svg.empty()) c.layers = {1};
    CHECK_THROWS_WITH(run_slice(c), Contains("pipe") && Contains("cannot be replaced"));
    CHECK_THROWS_AS(run_slice(c), UsageError);
    CHECK(fs::is_fifo(pipe));
    c.*member = taken.string();
    CHECK_THROWS_AS(run_slice(c), UsageError);
    fs::remove(pipe);
    fs::remove(taken);
  }
  REQUIRE(run_slice(o) == kOk);
  fs::create_symlink(o.output, link);
  const auto before = fs::file_size(o.output);
  o.output = link.string();
  o.support = "none";
  REQUIRE(run_slice(o) == kOk);
  CHECK(fs::is_symlink(link));
  CHECK(fs::file_size(link) != before);
  fs::remove(link);
}

TEST_CASE("A disk without room ends firn slice and leaves nothing behind") {
  SliceCommandOptions o = run_options("room");
  const fs::path folder =
      fs::path(o.output).parent_path() / "small-disk";  // of its own: other tests run beside it
  fs::create_directory(folder);
  rlimit limit{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &limit) == 0);
  const auto act = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, limit.rlim_max};
  for (const auto& [member, name] :
       {std::pair(&SliceCommandOptions::output, "x.paths"), std::pair(&SliceCommandOptions::gcode, "x.nc")}) {
    SliceCommandOptions c = o;
    c.output = "";
    c.*member = (folder / name).string();
    ::setrlimit(RLIMIT_FSIZE, &small);
    std::string what;
    try {
      run_slice(c);
    } catch (const UsageError&) {
      what = "a usage error";
    } catch (const std::exception& e) {
      what = e.what();
    }
    ::setrlimit(RLIMIT_FSIZE, &limit);
    CHECK_THAT(what, Contains("File too large"));
    CHECK(fs::is_empty(folder));
  }
  fs::remove(folder);
  std::signal(SIGXFSZ, act);
}

TEST_CASE("Ended by SIGTERM amid its layers, firn slice leaves nothing behind") {
  SliceCommandOptions o = run_options("ended");
  const fs::path folder = scratch("ended-folder");
  fs::remove_all(folder);
  fs::create_directory(folder);
  o.output = (folder / "a.paths").string();
  o.gcode = (folder / "a.gcode").string();
  o.overrides = {"layer.height_mm=0.005"};
  const auto before = std::signal(SIGTERM, SIG_DFL);
  const pid_t pid = ::fork();
  if (pid == 0) {
    record::remove_parts_on_signals();
    ::_exit(run_slice(o));
  }
  int status = 0;
  const auto over = [&] { return ::waitpid(pid, &status, WNOHANG) == pid; };
  while (fs::is_empty(folder) && !over()) ::usleep(1000);
  CHECK(::kill(pid, SIGTERM) == 0);
  ::waitpid(pid, &status, 0);
  std::signal(SIGTERM, before);
  const bool by_signal = WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM;
  CHECK((by_signal || (WIFEXITED(status) && WEXITSTATUS(status) == kInterrupted)));
  CHECK(fs::is_empty(folder));
  fs::remove_all(folder);
}

TEST_CASE("Option --support overhang takes its angle, and less support than full") {
  SliceCommandOptions o = run_options("overhang");
  const auto scaffold_mm = [&](const std::string& support, bool angle) {
    SliceCommandOptions c = o;
    c.support = support;
    if (angle) c.meshes.push_back("30");
    REQUIRE(run_slice(c) == kOk);
    LayerReader reader{fs::path(c.output)};
    while (reader.next()) {
    }
    CHECK(reader.head().settings.find("overhang_deg = " + std::string(angle ? "30.0" : "45.0")) !=
          std::string::npos);
    return reader.totals().use.size() > 1 ? reader.totals().use[1].length_mm : 0.0;
  };
  const double full = scaffold_mm("full", false), overhang = scaffold_mm("overhang", true),
               none = scaffold_mm("none", false);
  CHECK(none == 0.0);
  CHECK(overhang > 0.0);
  CHECK(full > overhang);
}
