// WayReadout reads the samples of its position that the controller records along a way, one question at a
// time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/stage/ensemble.h"
#include "drivers/stage/stage_config.h"
#include "drivers/stage/stage_way.h"

namespace firn::drivers {

/// Position feedback of X and Y along a way, sample k at k periods after its beginning. A Result follows.
struct FollowedWay {
  double period_s = 0.0;
  std::int64_t begin_us = 0;  ///< the program was started
  std::vector<float> x_mm, y_mm;
};

class WayReadout {
 public:
  /// Forgets the way before.
  /// @param wanted_s period of the samples; 0 = none
  /// @returns the period that the controller's memory allows [ms]; 0 = nothing is recorded
  std::int64_t prepare(const StageWay& way, double wanted_s);
  /// The controller's program is started.
  void begin(const StageWay& way, std::int64_t now_us);

  /// The next sample that the controller holds, else how many it holds, once a poll; else nothing.
  /// @param poll_us any number that differs from one poll of the motion to the next
  std::optional<Request> question(std::int64_t poll_us, const StageConfig& config,
                                  const ensemble::Table& table);
  /// Replies to the questions, and to one that the controller does not understand.
  void held(double samples);
  void take(std::int32_t index, double value_mm);
  void refused() { recording_ = false; }

  /// Gives up the samples that were read.
  FollowedWay take_followed();

 private:
  std::int32_t read_so_far() const { return std::int32_t(followed_.x_mm.size() + followed_.y_mm.size()); }

  FollowedWay followed_;          // x and y by turns
  std::int64_t first_ = 0;        // DGLOBAL of the first sample, behind the knots
  WayKnot start_;                 // of the way
  std::int32_t counted_ = 0;      // that the controller holds
  std::int64_t counted_for_ = 0;  // poll for which they were counted last
  bool recording_ = false;
  double plausible_mm_ = 0.0;  // that a sample may be away from where those before it lead
  bool again_ = false;         // the last one was implausible and is read once more
};

}  // namespace firn::drivers
