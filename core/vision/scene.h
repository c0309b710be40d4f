// Scene computes opacity: how much of the light of its ground a pixel lacks, 0 = ground, 1 = opaque object.
#pragma once

#include <span>
#include <vector>

#include "core/vision/frame.h"
#include "core/vision/light.h"

namespace firn::vision {

/// The static background of a set of pictures: all that does not move.
struct Background {
  Frame frame;
  std::vector<std::uint8_t> nozzle;  ///< 1 where a pixel belongs to an object that reaches the picture's edge
  bool inverted = false;             ///< its objects are brighter than its ground; `frame` is inverted then
};

class Scene {
 public:
  /// @param background or nullptr; of the same size, its objects darker than its ground
  Scene(const Frame& frame, const Light& light, const Background* background);

  const Frame& frame() const { return frame_; }
  const Light& light() const { return light_; }

  /// Grey level of the ground: of the background picture, and of the smooth ground where the nozzle is, so
  /// that the nozzle stays an object. 0 depth, hence opacity 0, where the background is nearly as dark as an
  /// object.
  double ground(int x, int y) const {
    if (background_) {
      const std::size_t i = frame_.index(x, y);
      if (!background_->nozzle[i]) return gain_ * double(background_->frame.pixels[i]);
    }
    return double(
        light_.ground[std::size_t(y / kBlock) * std::size_t(light_.columns) + std::size_t(x / kBlock)]);
  }
  double opacity(int x, int y) const {
    const double g = ground(x, y), depth = g - light_.dark;
    return depth > least_depth_ ? (g - double(frame_.at(x, y))) / depth : 0.0;
  }
  /// The largest grey level at which a pixel of a block's ground has an opacity above `level`, -1 if none
  /// has.
  /// @pre it lies on the smooth ground: there is no background
  int darkest_above(int x, int y, double level) const;
  bool has_background() const { return background_ != nullptr; }
  /// Bilinear, inside the picture.
  double opacity(double x, double y) const;
  /// Standard deviation of a pixel's opacity.
  double noise() const { return light_.noise / std::max(1.0, light_.depth); }

 private:
  const Frame& frame_;
  const Light& light_;
  const Background* background_;
  double gain_ = 1.0, least_depth_ = 1.0;
};

/// One run of pixels of a row.
struct Run {
  int y = 0, x0 = 0, x1 = 0;  ///< x1 is the last pixel
};

/// Connected pixels (8 neighbours) whose opacity is above a level.
struct Component {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< bounding box, inclusive
  long area = 0;
  bool at_edge = false;   ///< reaches the picture's edge
  std::vector<Run> runs;  ///< rows from the top, x ascending
};

/// @param level opacity, above 0
std::vector<Component> find_components(const Scene& scene, double level);

/// The static picture of a scene, brightness made equal: in each pixel the level that seven tenths of the
/// pictures do not exceed, or three tenths where objects are bright, so that a ligament, a droplet and its
/// satellites may pass one after the other. Empty pixels when fewer than five pictures share the scene, or
/// when a picture differs from it in more than a fifth of its pixels.
Frame static_picture(std::span<const Frame* const> frames, bool bright);

}  // namespace firn::vision
