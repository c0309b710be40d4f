// PlyHeader holds the declarations of a PLY header.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace firn::mesh {

enum class PlyType { kNone, kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kNone;        ///< of each entry, if a list
  PlyType count_type = PlyType::kNone;  ///< of a list's length
  int axis = -1;                        ///< 0, 1, 2 = x, y, z of a vertex
  bool is_list() const { return count_type != PlyType::kNone; }
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_list() const { return std::ranges::any_of(properties, &PlyProperty::is_list); }
};
/// Returns the minimum bytes of a binary row: lists may be empty.
std::size_t min_bytes(const PlyElement& element);

struct PlyHeader {
  bool text = false, big_endian = false;
  std::vector<PlyElement> elements;      ///< "vertex" precedes "face", each once
  std::optional<std::size_t> face_list;  ///< the property of "face" that names vertices
  std::size_t bytes = 0, lines = 0;      ///< of the header with its end
};

/// @throws UsageError naming the line
PlyHeader read_ply_header(std::string_view text, const std::string& name);

}  // namespace firn::mesh
