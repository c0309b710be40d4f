// read_mesh reads meshes from STL (binary, ASCII), PLY (binary of both byte orders, ASCII), OBJ and 3MF, in
// one pass over the mapped file. An invalid file is an error; a readable oddity is a defect.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/slice/mesh/facets.h"
#include "files/record/file.h"

namespace firn {

/// Triangles of one file, as numbers of the file.
struct MeshData {
  std::string format;                   ///< "binary STL", "ASCII PLY", …
  double mm_per_unit = 1.0;             ///< 3MF names its unit; the others are taken as millimetres
  std::vector<slice::Corner> vertices;  ///< indexed formats; about `origin`, as `soup`
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> soup;             ///< ASCII STL: nine numbers a facet
  std::span<const std::byte> records;  ///< binary STL: its records of 50 bytes, in the bytes that were read
  std::array<double, 3> origin{};      ///< to be added to vertices and soup
  std::vector<std::string> defects;    ///< "17 faces have fewer than 3 corners"

  slice::FacetView facets() const;  ///< valid as long as this and the bytes that were read
};

inline constexpr std::size_t kMaxFacets = std::size_t(1) << 30;

/// Which number of facets holds where a header's count and the file's size disagree.
enum class FacetCount {
  kAgree,   ///< neither: such a file is refused
  kHeader,  ///< the header's, if the file has so many
  kFile,    ///< as many as the file holds
};

/// Reads bytes of the format that `name` ends with: .stl, .ply, .obj, .3mf, in any case. Polygons become
/// triangles.
/// @throws UsageError naming `name`, byte or line, and the problem with the limit: an unknown ending or
/// header, counts that contradict the file's length, an index without vertex, an invalid number, a truncated
/// file, something that changes the solid and is not read, no facet.
MeshData read_mesh(std::span<const std::byte> bytes, const std::string& name,
                   FacetCount count = FacetCount::kAgree);

/// A mapped file and its mesh.
class MeshFile {
 public:
  /// @throws UsageError: as read_mesh; no such file
  explicit MeshFile(const std::filesystem::path& file, FacetCount count = FacetCount::kAgree);
  const MeshData& data() const { return data_; }
  std::uint64_t bytes() const { return map_.bytes().size(); }
  /// The view of data(); pages that the slicer has read leave memory.
  slice::FacetView facets() const;

 private:
  record::MappedFile map_;
  MeshData data_;
};

}  // namespace firn
