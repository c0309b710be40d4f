// StagePlace tells where a simulated stage is, of any kind.
#pragma once

#include <cstdint>

#include "plant/twins/motion.h"

namespace firn::plant {

class StagePlace {
 public:
  virtual ~StagePlace() = default;
  virtual Vec3 position_mm(std::int64_t now_us) const = 0;  ///< true
  virtual double velocity_mm_s(int axis, std::int64_t now_us) const = 0;
  /// Of the encoder, or of the steps that stand for it, at a place.
  virtual std::int64_t encoder_counts(int axis, double position_mm) const = 0;
  /// The profiler's encoder input is on X, not on Y.
  virtual bool encoder_crossed() const { return false; }
};

}  // namespace firn::plant
