// PictureSource gives grey pictures one at a time: a V4L2 device or a folder.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn::camera {

/// The source has gone, as a device that was unplugged. Other failures of one picture are std::runtime_error.
struct SourceGone : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct ShotSettings {
  double exposure_us = 100.0, gain_db = 0.0, delay_us = 0.0;
  bool operator==(const ShotSettings&) const = default;
};

/// Rows from the top; `white` is the largest value that a pixel can take.
struct GreyShot {
  int width = 0, height = 0, white = 255;
  std::int64_t age_us = 0;  ///< from the exposure until now
  std::vector<std::uint16_t> pixels;
};

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  virtual std::string name() const = 0;
  /// @returns why it cannot have these settings; empty = it has them now
  virtual std::string set_up(const ShotSettings& settings) = 0;
  /// A picture exposed after this call. @param ended asked while it waits: the picture is not wanted any more
  /// @throws SourceGone; std::runtime_error: no picture, the source stays
  virtual GreyShot take(const std::function<bool()>& ended) = 0;
};

}  // namespace firn::camera
