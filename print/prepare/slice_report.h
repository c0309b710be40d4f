// Writes the report of firn slice on a job, as JSON and as text.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/slice/paths/path_codec.h"
#include "print/prepare/slice_job.h"

namespace firn {

/// Holds sums over the layers of a job.
struct SliceSums {
  slice::PathFileTotals totals;
  double transit_mm = 0.0;
  std::uint64_t clipper_rings = 0;
  struct Layer {
    std::int32_t layer = 0;
    std::vector<slice::Coverage> coverage;
  };
  std::vector<Layer> coverage;  ///< of each layer, if the settings ask for it

  void add(const PlannedLayer& layer);
};

struct SliceOutput {
  std::string file;
  std::uint64_t bytes = 0;
};

std::string slice_json(const SlicedJob& job, const SliceSettings& settings, const SliceSums& sums,
                       const std::vector<SliceOutput>& outputs, int threads);
std::string slice_text(const SlicedJob& job, const SliceSettings& settings, const SliceSums& sums);

/// Returns "part", "scaffold", "material 2", …
std::string material_name(std::size_t material);

}  // namespace firn
