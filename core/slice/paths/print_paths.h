// PrintPaths holds all paths of a print in memory, so that the nodes of a run never slice. Its framing is not
// that of a path file (files/path/layer_file.h): core reads no files, the run's manifest holds the SHA-256 of
// the whole, and the runs that were recorded with it must be read for ever.
#pragma once

#include "core/slice/paths/path_codec.h"

namespace firn::slice {

struct PrintPaths {
  PathFileHead head;
  std::vector<LayerPaths> layers;  ///< ascending
};

/// "FIRNPTH1", u32 records, then per record u32 length and the payload of docs/formats.md: head first,
/// then the layers.
/// @throws std::invalid_argument: as encode(LayerPaths); layers that do not ascend
std::vector<std::byte> encode(const PrintPaths& paths);
/// Takes any bytes. @throws FormatError naming the byte
PrintPaths decode_print_paths(std::span<const std::byte> bytes);

/// Returns the layer for the measurement of the bare table before the first layer (ice.map_table): layer 0 at
/// height 0, with the lines of the first layer that has measurement paths. Its deposition lines mark the area
/// of the part and are not deposited. @throws std::invalid_argument: no layer has measurement paths
LayerPaths table_layer(const PrintPaths& paths);
/// Returns the paths with that layer before them.
PrintPaths with_table(PrintPaths paths);

/// Returns the layer of that number, or nullptr if there is no such layer.
const LayerPaths* find_layer(const PrintPaths& paths, std::int32_t layer);

}  // namespace firn::slice
