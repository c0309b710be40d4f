// PlanDecision holds the answer of a controller to a measured surface. The numbers are those of layer_plan_t
// and control_surface_t.
#pragma once

#include <cstdint>

namespace firn {

enum class PlanDecision : std::int8_t {
  kPrint = 0,
  kEnd = 1,   ///< the part is finished
  kStop = 2,  ///< the operator must decide
};

}  // namespace firn
