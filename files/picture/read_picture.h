// read_picture reads a camera's picture as grey levels.
#pragma once

#include <filesystem>

#include "files/picture/codecs.h"

namespace firn {

/// The largest file of a picture [bytes].
inline constexpr std::size_t kMaxPictureFile = std::size_t(1) << 30;

/// @throws UsageError naming the file and what is wrong: missing, too large, damaged, of an unknown format;
/// or that the plug-in is missing, and how it is made
DecodedPicture read_picture(const std::filesystem::path& file);

}  // namespace firn
