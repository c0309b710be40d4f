// Tags name the purpose of a request to the stage, by which its reply is understood.
#pragma once

#include <cstdint>

namespace firn::drivers::stage_tag {

enum Tag : std::uint16_t {
  kPlain,
  kHarmless,    ///< it may be refused
  kTriggerOff,  ///< likewise
  kStatus,
  kPlane,
  kPosition,
  kCount,
  kFaultBits,
  kIncrement,
  kMotion,
  kParameter,
  kTask,
  kSamples,  ///< how many the controller holds of a way
  kSample
};

}  // namespace firn::drivers::stage_tag
