#include "print/inputs/part_experiment.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "config/include.h"
#include "files/lowercase.h"
#include "files/usage_error.h"
#include "print/inputs/mesh_part.h"
#include "print/inputs/targets.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPictures[] = {".png", ".jpg", ".jpeg"};
constexpr std::string_view kMeshes[] = {".stl", ".ply", ".obj", ".3mf"};
constexpr double kUsedShare = 0.9;  // of the grid, so that droplets beside the rim are measured too

bool ends_in(const fs::path& file, std::span<const std::string_view> endings) {
  return std::ranges::find(endings, lowercase(file.extension().string())) != endings.end();
}

// A basic string of TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      throw UsageError(text + ": a file's name with a control character");
    out += c;
  }
  return out + "\"";
}

// Relative within the folder, so that both can be moved; whole beyond it.
std::string path_from(const fs::path& folder, const fs::path& file) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  const fs::path relative = whole.lexically_relative(fs::absolute(folder).lexically_normal());
  return quoted((relative.empty() || *relative.begin() == ".." ? whole : relative).string());
}

std::string run_name(const fs::path& part) {
  std::string name;
  for (const char c : part.stem().string())
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ? c : '-';
  return name.empty() ? "part" : name;
}

// An ice lab without a part is no whole experiment: its kind is read from the texts.
std::string kind_of(const fs::path& lab) {
  std::string kind = "inkjet";
  for (const auto& [file, text] : read_with_includes(lab))
    if (const std::string named = lab_kind_in(text); named != "inkjet")
      kind = named;  // which a text that names none has
  return kind;
}

double usable_mm(int cells, double pitch_mm) { return kUsedShare * cells * pitch_mm; }

std::string inkjet_picture(const PartRequest& r, const GridSpec& g, const std::string& file) {
  const std::array<int, 2> pixels = picture_pixels(read_bytes(r.part, "part.image"), r.part.string());
  const double width_mm = r.width_mm > 0.0 ? r.width_mm
                                           : std::min(usable_mm(g.nx, g.pitch_x_mm),
                                                      usable_mm(g.ny, g.pitch_y_mm) * pixels[0] / pixels[1]);
  return fmt::format(
      "shape = \"height_map\"\nimage = {}\nimage_white_mm = {}       # the brightest grey\nwidth_mm = {:.6g} "
      "          "
      "# its depth follows from its aspect\n",
      file, r.height_mm, width_mm);
}

std::string inkjet_mesh(const PartRequest& r, const GridSpec& g, const std::string& file) {
  const BoxSize size = MeshPart(r.part, "part.mesh", 1.0, 1.0, 0.0).size_mm();
  if (!(size[2] > 0.0)) throw UsageError(r.part.string() + ": the mesh is flat");
  const double fits =
      std::min({1.0, usable_mm(g.nx, g.pitch_x_mm) / size[0], usable_mm(g.ny, g.pitch_y_mm) / size[1]});
  const double scale_xy = r.width_mm > 0.0 ? r.width_mm / size[0] : fits;
  return fmt::format(
      "shape = \"mesh\"\nmesh = {}           # {}\nmesh_scale_xy = {:.9g}\nmesh_scale_z = {:.9g}    # {} mm "
      "high\n",
      file, box_text(size), scale_xy, r.height_mm / size[2], r.height_mm);
}

std::string ice_mesh(const PartRequest& r, const std::string& file) {
  const double high_mm = MeshPart(r.part, "ice.mesh", 1.0, 1.0, 0.0).size_mm()[2];
  if (r.height_mm > high_mm)
    throw UsageError(
        fmt::format("--height {}: {} is {:.6g} mm high, and the ice lab prints meshes in their own size",
                    r.height_mm, r.part.string(), high_mm));
  std::string text = "mesh = " + file + "\n";
  if (r.height_mm > 0.0)
    text += fmt::format("height_mm = {}            # of {:.6g} mm\n", r.height_mm, high_mm);
  return text;
}

}  // namespace

bool names_part(const fs::path& file) { return ends_in(file, kPictures) || ends_in(file, kMeshes); }

std::string experiment_of_part(const PartRequest& r, const fs::path& folder) {
  const std::string file = path_from(folder, r.part), kind = kind_of(r.lab);
  const bool picture = ends_in(r.part, kPictures);
  std::string text =
      fmt::format("include = {}\n\n[run]\nname = {}\n\n", path_from(folder, r.lab), quoted(run_name(r.part)));
  if (kind == "ice") {
    if (picture)
      throw UsageError(r.part.string() + ": the ice lab prints meshes (STL, PLY, OBJ, 3MF), no pictures");
    if (r.width_mm > 0.0) throw UsageError("--width: the ice lab prints meshes in their own size");
    return text + "[ice]\n" + ice_mesh(r, file);
  }
  if (kind != "inkjet")
    throw UsageError(r.part.string() + ": the lab " + r.lab.string() + " is of kind \"" + kind +
                     "\", which prints lines; write an experiment for it: docs/aerosol.md");
  if (!(r.height_mm > 0.0))
    throw UsageError(r.part.string() + ": --height MM is missing: how high the part will be");
  const GridSpec grid = load_experiment(r.lab, {}, LabUse::kAlone).grid;
  return text + "[part]\n" + (picture ? inkjet_picture(r, grid, file) : inkjet_mesh(r, grid, file));
}

}  // namespace firn
