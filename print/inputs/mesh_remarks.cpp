// Remarks on a mesh that can be printed but may not be meant.
#include <fmt/core.h>

#include <algorithm>

#include "core/slice/mesh/slicer.h"
#include "print/inputs/mesh_part.h"

namespace firn {
namespace {

constexpr double kInch_mm = 25.4;
constexpr double kFewDetails = 5.0;  // a part of fewer widths of a bead or a cell is hardly meant

}  // namespace

std::vector<std::string> mesh_remarks(const std::filesystem::path& file, const std::string& key,
                                      double scale_xy, double scale_z, double detail_mm, FacetCount count) {
  const MeshPart part(file, key, scale_xy, scale_z, 0.0, count);
  std::vector<std::string> remarks = part.file().data().defects;
  if (!slice::intersect(part.file().facets(), part.place(), {}, serially).facts.closed)
    remarks.push_back("the surface is open or inconsistently oriented: what is inside is a guess");
  if (part.place().coarse_mm > slice::kCoarse_mm)
    remarks.push_back(
        fmt::format("its coordinates lie so far from the origin that the file has lost digits of "
                    "them: they are {:.3g} mm apart",
                    part.place().coarse_mm));
  const BoxSize& size = part.size_mm();
  if (std::max(size[0], size[1]) < kFewDetails * detail_mm)
    remarks.push_back(fmt::format("the part is only {}; taken as inches it would be {}", box_text(size),
                                  box_text({size[0] * kInch_mm, size[1] * kInch_mm, size[2] * kInch_mm})));
  for (std::string& r : remarks) r = file.string() + ": " + r;
  return remarks;
}

}  // namespace firn
