// Scene computes opacity: how much of the light of its ground a pixel lacks, 0 = ground, 1 = opaque object.
#pragma once

#include <span>
#include <vector>

#include "core/vision/frame.h"
#include "core/vision/illumination.h"

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
  Scene(const Frame& frame, const Illumination& illumination, const Background* background);

  const Frame& frame() const { return frame_; }
  const Illumination& illumination() const { return illumination_; }

  /// Grey level of the ground: of the background picture, and of the smooth ground where the nozzle is, so
  /// that the nozzle stays an object. 0 depth, hence opacity 0, where the background is nearly as dark as an
  /// object.
  double ground(int x, int y) const {
    if (background_) {
      const std::size_t i = frame_.index(x, y);
      if (!background_->nozzle[i]) return gain_ * double(background_->frame.pixels[i]);
    }
    return double(illumination_.ground[std::size_t(y / kBlock) * std::size_t(illumination_.columns) +
                                       std::size_t(x / kBlock)]);
  }
  double opacity(int x, int y) const {
    const double g = ground(x, y), depth = g - illumination_.dark;
    return depth > min_depth_ ? (g - double(frame_.at(x, y))) / depth : 0.0;
  }
  /// The largest grey level whose opacity is above `level` at a pixel and its block, -1 if none has.
  /// @pre it lies on the smooth ground: there is no background
  int grey_threshold(int x, int y, double level) const;
  bool has_background() const { return background_ != nullptr; }
  /// Bilinear, inside the picture.
  double opacity(double x, double y) const;
  /// Standard deviation of a pixel's opacity.
  double noise() const { return illumination_.noise / std::max(1.0, illumination_.depth); }

 private:
  const Frame& frame_;
  const Illumination& illumination_;
  const Background* background_;
  double gain_ = 1.0, min_depth_ = 1.0;
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

/// Opacity above which touching pixels are one object. Chosen on rendered pictures: below half of a rim, so
/// that a blurred ligament stays whole, and above what uneven light leaves.
inline constexpr double kObjectOpacity = 0.28;

/// @param level opacity, above 0
std::vector<Component> find_components(const Scene& scene, double level);

/// The static picture of a scene, brightness made equal: in each pixel the level that seven tenths of the
/// pictures do not exceed, or three tenths where objects are bright, so that a ligament, a droplet and its
/// satellites may pass one after the other. Empty pixels when fewer than five pictures share the scene, or
/// when a picture differs from it in more than a fifth of its pixels.
Frame static_picture(std::span<const Frame* const> frames, bool bright);

}  // namespace firn::vision
