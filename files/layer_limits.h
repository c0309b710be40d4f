// Limits of a layer-wise record, and counting of its cells, for the readers of tables and of folders.
#pragma once

#include <limits>
#include <string>

#include "files/layer_record.h"

namespace firn {

inline constexpr int kMaxLayers = 100'000;
inline constexpr std::size_t kMaxCells = std::size_t(1) << 28;  ///< of all layers: 2 GB
inline constexpr double kFarthest_mm = 1e6;  ///< of a position or height: beyond it stands no sample

inline constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();  ///< a cell without a sample

/// @throws UsageError: more cells than can be held
void check_record_size(const std::string& name, std::size_t layers, const GridSpec& grid);
/// Counts heights and missing cells of layers with a height. @param ground_known false for an assumed ground
void count_cells(LayerRecord& record, bool ground_known);
/// Makes heights of a record whose `heights` are increments: summed from the first layer that has any, on a
/// base that is at its target, or else flat at 0; missing ones are bridged (files/increments.h). Says so in
/// `assumptions`.
void sum_increments(LayerRecord& record);
/// Sets the targets of a record of errors: height - error. @param errors [layer] [mm], kUnmeasured where
/// missing
void set_targets_of_errors(LayerRecord& record, const std::vector<HeightMap>& errors);

}  // namespace firn
