// frame_of() decodes the picture of a CAMERA_FRAME.
#pragma once

#include "core/vision/frame.h"
#include "firn/camera_frame_t.hpp"

namespace firn {

/// @throws PngError: the bytes are no grey PNG picture of the message's size
vision::Frame frame_of(const camera_frame_t& message);

}  // namespace firn
