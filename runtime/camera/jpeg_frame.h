// decode_jpeg_frame decodes a frame of a camera that packs its pictures as JPEG (MJPG), by the plug-in that
// decodes pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace firn::camera {

/// A JpegDecoder. A frame without Huffman tables, as Motion JPEG allows, has the standard ones.
/// @throws std::runtime_error: the plug-in is missing
std::vector<std::uint16_t> decode_jpeg_frame(std::span<const std::byte> file, int width, int height);

}  // namespace firn::camera
