// each_truth() reads the true surfaces of a simulated run, layer by layer, from its log.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "core/grid/grid.h"

namespace firn::runs {

/// Calls `use` with each SIM_TRUTH of the log and the layer of the LAYER_METRICS before it. SIM_TRUTH comes
/// from the launcher, which has no write-ahead file: the log alone holds it. Damaged ones are left out; a run
/// without a log has none.
void each_truth(const std::filesystem::path& run,
                const std::function<void(std::int32_t layer, HeightMap surface)>& use);

}  // namespace firn::runs
