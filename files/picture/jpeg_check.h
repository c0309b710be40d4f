// damage_of_jpeg finds damaged data in a JPEG file, which decoders repair with a warning and grey stretches.
#pragma once

#include <span>
#include <string>

namespace firn {

/// Decodes the file at an eighth of its size and keeps what the decoder says of it.
/// @returns libjpeg's first complaint; empty: the file is sound, or too large to be looked at. @pre it begins
/// as a JPEG file
std::string damage_of_jpeg(std::span<const unsigned char> file);

}  // namespace firn
