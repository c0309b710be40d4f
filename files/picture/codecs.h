// PictureCodec is the interface of the plug-in that decodes pictures: its 120 libraries take 65 ms to load,
// so no program is linked with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace firn {

struct DecodedPicture {
  int width = 0, height = 0;
  int white =
      255;  ///< 255, or of deeper pictures the smallest of 1023, 4095, 16383 and 65535 that no pixel exceeds
  std::vector<std::uint16_t> pixels;  ///< grey, rows from the top
  std::string error;                  ///< not empty: no picture
};

inline constexpr const char* kPictureCodec = "firn_decode_picture";
using PictureCodec = void (*)(std::span<const unsigned char> file, DecodedPicture& picture);

}  // namespace firn
