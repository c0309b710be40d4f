// DispenserPhoto holds a drawn picture of an ink-jet dispenser as cameras of laboratories take them, with the
// droplets that are in it.
#pragma once

#include <bitset>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/vision/droplets.h"

namespace firn {

/// Properties that photos are drawn with, in the order of kPhotoTraits.
enum class PhotoTrait {
  kDarkField,
  kSpecularMiddle,
  kTaperedNozzle,
  kGlassNozzle,
  kNoNozzle,
  kNozzleAtSide,
  kReflection,
  kVignette,
  kMotionBlur,
  kColour,
  kPalette,
  kLowQuality,
  kSmallPicture,
  kDefocus,
  kSatellites,
  kTrain,
  kTail,
  kLigament,
  kBeads,
  kTwoJoined,
  kNoDrop,
  kMeniscus,
};
inline constexpr const char* kPhotoTraits[] = {
    "dark field", "specular middle", "tapered nozzle", "glass nozzle",   "no nozzle", "nozzle at a side",
    "reflection", "vignette",        "motion blur",    "colour",         "palette",   "quality below 50",
    "320 x 240",  "out of focus",    "satellites",     "train of equal", "tail",      "ligament",
    "with beads", "two joined",      "no drop",        "meniscus"};

struct PhotoDisc {
  double x = 0.0, y = 0.0, radius = 0.0;  ///< [px]
};

struct DispenserPhoto {
  std::vector<unsigned char> file;  ///< JPEG or PNG
  vision::PictureState state = vision::PictureState::kDrop;
  std::vector<PhotoDisc> main;  ///< each of them may be taken for the main droplet; none of kNoDrop
  std::bitset<std::size(kPhotoTraits)> traits;

  bool has(PhotoTrait t) const { return traits[std::size_t(t)]; }
};

DispenserPhoto draw_dispenser(std::uint64_t seed);

}  // namespace firn
