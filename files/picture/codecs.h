// PictureCodec is the interface of the plug-in that decodes pictures: its 120 libraries take 65 ms to load,
// so no program is linked with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace firn {

inline constexpr int kWhiteOf8Bits = 255;

/// White level of a picture of more than 8 bits, whose file does not hold it: the smallest of 10, 12, 14 and
/// 16 bits that no pixel exceeds.
inline int deep_white_level(int brightest) {
  for (const int white : {1023, 4095, 16383})
    if (brightest <= white) return white;
  return 65535;
}

struct DecodedPicture {
  int width = 0, height = 0;
  int white = kWhiteOf8Bits;          ///< of 8 bits, else deep_white_level() of its brightest pixel
  std::vector<std::uint16_t> pixels;  ///< grey, rows from the top
  std::string error;                  ///< not empty: no picture
  std::vector<std::string> remarks;   ///< "page 1 of 2 is read"
};

inline constexpr const char* kPictureCodec = "firn_decode_picture";
using PictureCodec = void (*)(std::span<const unsigned char> file, DecodedPicture& picture);

}  // namespace firn
