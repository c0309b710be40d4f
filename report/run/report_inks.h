// Writes the report's section for prints with two inks: the wanted and the planned ink of each cell, layer by
// layer, and the printed block [Lu 2015, IV-B, Figs. 13-15].
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/grid/geometry.h"
#include "core/grid/material_columns.h"
#include "runs/read/run_messages.h"

namespace firn::report {

/// Holds one printed layer: the inks of its cells as the controller planned them, and the surface that was
/// measured after it.
struct InkLayer {
  std::int32_t layer = 0;
  double height_mm = 0.0;  ///< mean of that surface where ink was printed
  MaterialMap planned;
  MaterialMap wanted;  ///< the object's mask at the surface before the layer, cell by cell
};

struct InkData {
  Geometry geometry;
  MaterialColumns printed;  ///< from the record: planned ink, as thick as the measured surface rose
  std::vector<InkLayer> layers;
};

/// Reads the inks of a run; empty if no layer with two inks was printed and measured.
/// @param geometry the run's input of that name
/// @param block cells that are printed
/// @throws std::invalid_argument: damaged geometry
std::optional<InkData> read_ink_data(const runs::RunMessages& messages, std::span<const std::byte> geometry,
                                     const Mask& block);

struct NamedInks {
  std::string name;
  const InkData* data;
};
/// Returns HTML; empty for no run.
std::string ink_sections(const std::vector<NamedInks>& runs);

}  // namespace firn::report
