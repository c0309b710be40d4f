// Encodes and decodes deposition paths, one layer at a time. Format: docs/formats.md; version 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/path/bytes.h"
#include "core/slice/paths/layer_paths.h"

namespace firn::slice {

inline constexpr std::uint32_t kPathVersion = 1;
inline constexpr std::int32_t kMaxPathUnits =
    (1 << 30) - 1;  ///< maximum of coordinates, heights and widths, either way

/// The head of a path file: units, materials and origin.
struct PathFileHead {
  struct Material {
    std::string name;  ///< "part", "scaffold", …
    std::string tool;  ///< of the machine that plans them: "water", …
    bool operator==(const Material&) const = default;
  };
  std::string made_by;              ///< program and commit
  std::int32_t layers = 0;          ///< number of layers in the file
  std::vector<Material> materials;  ///< PathInfo.material counts them from 0
  std::string laser;                ///< tool of measurement paths
  std::string settings;             ///< the resolved slice.toml, at most 64 KiB
  bool operator==(const PathFileHead&) const = default;
};

/// The totals at the end of a complete file.
struct PathFileTotals {
  std::int64_t layers = 0, paths = 0, points = 0;
  std::vector<MaterialUse> use;  ///< by material
};

std::vector<std::byte> encode(const PathFileHead& head);
/// Encodes points as differences: two to three bytes a coordinate at distances of some 0.1 mm.
/// @throws std::invalid_argument: number of infos different from that of lines, a line without points, a
/// number beyond kMaxPathUnits
std::vector<std::byte> encode(const LayerPaths& layer);
std::vector<std::byte> encode(const PathFileTotals& totals);

// Accept any bytes. @throws FormatError: an unknown version or kind, a count above its limit, a material
// missing in the head, a number out of range, bytes missing or left over.
PathFileHead decode_path_head(std::span<const std::byte> bytes);
LayerPaths decode_layer_paths(std::span<const std::byte> bytes, const PathFileHead& head);
PathFileTotals decode_path_totals(std::span<const std::byte> bytes);

}  // namespace firn::slice
