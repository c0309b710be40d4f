// heights_told() tells LAYER_METRICS of a measured surface from that of a camera alone, which has no heights.
#pragma once

#include "firn/layer_metrics_t.hpp"

namespace firn {

/// False where no map led to the message: its heights and errors are all 0 then.
inline bool heights_told(const layer_metrics_t& m) { return m.map_id > 0 || m.rms_mm > 0.0; }

}  // namespace firn
