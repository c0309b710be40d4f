// DropletPicture holds main droplet, satellites, ligament and nozzle of one strobe picture.
#pragma once

#include <optional>
#include <vector>

#include "core/vision/nozzle.h"
#include "core/vision/outline.h"

namespace firn::vision {

struct Droplet {
  double x = 0.0, y = 0.0;                          ///< centroid [px]
  double x_std = 0.0, y_std = 0.0;                  ///< standard deviations [px]
  double diameter_px = 0.0, diameter_std_px = 0.0;  ///< of the circle of equal area; without tail or ligament
  double axis_ratio = 1.0;                          ///< axis along the flight over axis across it
  double tail_px = 0.0;  ///< length of a tail, ligament or neighbour that is joined to it
  double opacity = 0.0;  ///< 0 = ground, 1 = as dark as the darkest object
  bool joined = false;   ///< to the nozzle, or to liquid that leaves the picture
};

enum class PictureState { kNoDrop, kDrop, kNotBrokenOff };

/// Diameter of a satellite over that of the main droplet, at most.
inline constexpr double kSatelliteShare = 0.75;

struct DropletPicture {
  PictureState state = PictureState::kNoDrop;
  Droplet main;                     ///< of kDrop and kNotBrokenOff
  std::vector<Droplet> drops;       ///< further droplets of about the main one's size, the largest first
  std::vector<Droplet> satellites;  ///< smaller ones, the largest first
  int cut_off = 0;                  ///< objects that the picture's edge cuts, without the nozzle
  Nozzle nozzle;
  bool bright = false;   ///< objects are brighter than their ground
  double noise = 0.0;    ///< standard deviation of a pixel's opacity
  double blur_px = 0.0;  ///< standard deviation of the main droplet's edge spread
  bool used_background = false;
};

struct DropletOptions {
  Polarity polarity = Polarity::kAuto;
  double min_opacity = 0.4;     ///< of a droplet's rim: paler objects are dirt or out of focus
  double min_main_px = 5.0;     ///< diameter of a main droplet
  double min_satellite_px = 2;  ///< diameter of a satellite
};

/// Finds the droplets of one picture. The main droplet is the largest one; a free one goes before a meniscus.
/// @param background static background of the same camera, or nullptr: then the smooth ground alone is known,
/// and dark round dirt cannot be told from a droplet. @pre its size is the frame's
/// @returns no drop also for a frame that is not valid
DropletPicture find_droplets(const Frame& frame, const Background* background,
                             const DropletOptions& options = {});

/// The background of pictures that share a scene; nothing when one is not valid, when they do not
/// (static_picture), when the scene itself shows a droplet and `moves` is false (pictures of one delay keep
/// their droplet in place), or when droplets that move too slowly have left their shadow in it.
std::optional<Background> find_background(std::span<const Frame* const> frames, bool moves,
                                          const DropletOptions& options = {});

/// The background that a picture without a droplet shows; empty for one that is not valid.
Background known_background(const Frame& frame, Polarity objects);

}  // namespace firn::vision
