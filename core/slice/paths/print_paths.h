// All paths of a print in one piece of memory: what a run is given, so that its nodes never slice.
#pragma once

#include "core/slice/paths/path_codec.h"

namespace firn::slice {

struct PrintPaths {
  PathFileHead head;
  std::vector<LayerPaths> layers;  ///< ascending
};

/// "FIRNPTH1", u32 records, then per record u32 length and the payload of docs/path-format.md: head first,
/// then the layers.
/// @throws std::invalid_argument: as encode(LayerPaths); layers that do not ascend
std::vector<std::byte> encode(const PrintPaths& paths);
/// Takes any bytes. @throws FormatError naming the byte
PrintPaths decode_print_paths(std::span<const std::byte> bytes);

/// The bare table as it is measured before the first layer (ice.map_table): layer 0 at height 0, with the
/// lines of the first layer that has measurement paths. Its beads tell where the part will stand; none of
/// them is laid. @throws std::invalid_argument: no layer has any
LayerPaths table_layer(const PrintPaths& paths);
/// The same paths with that layer before them.
PrintPaths with_table(PrintPaths paths);

/// The layer of that number. @returns nullptr when there is none
const LayerPaths* find_layer(const PrintPaths& paths, std::int32_t layer);

}  // namespace firn::slice
