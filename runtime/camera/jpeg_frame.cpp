#include "runtime/camera/jpeg_frame.h"

#include <stdexcept>
#include <string>

#include "files/picture/read_picture.h"

namespace firn::camera {

std::vector<std::uint16_t> decode_jpeg_frame(std::span<const std::byte> file, int width, int height) {
  DecodedPicture picture = decode_picture({reinterpret_cast<const unsigned char*>(file.data()), file.size()});
  if (!picture.error.empty()) throw std::length_error("a JPEG frame: " + picture.error);
  if (picture.width != width || picture.height != height)
    throw std::length_error("a JPEG frame of " + std::to_string(picture.width) + " x " +
                            std::to_string(picture.height) + " px where " + std::to_string(width) + " x " +
                            std::to_string(height) + " are negotiated");
  return std::move(picture.pixels);
}

}  // namespace firn::camera
