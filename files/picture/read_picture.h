// read_picture reads a camera's picture as grey levels.
#pragma once

#include <filesystem>

#include "files/picture/codecs.h"

namespace firn {

/// The largest file of a picture [bytes].
inline constexpr std::size_t kMaxPictureFile = std::size_t(1) << 30;

/// Decodes the bytes of a picture file. @throws UsageError: the plug-in is missing, and how it is made
DecodedPicture decode_picture(std::span<const unsigned char> bytes);

/// @throws UsageError naming the file and what is wrong: missing, too large, damaged, of an unknown format;
/// or that the plug-in is missing, and how it is made
DecodedPicture read_picture(const std::filesystem::path& file);

/// A rectangle of pixels; (x, y) is its first one.
struct PictureCrop {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The rectangle of a picture. Its white level is that of its own pixels: a caption beside it does not count.
/// @param file names the picture in the error
/// @throws UsageError naming the picture, its size and the rectangle that leaves it
DecodedPicture cropped(const DecodedPicture& picture, const PictureCrop& crop,
                       const std::filesystem::path& file);

}  // namespace firn
