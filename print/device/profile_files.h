// profile_files writes profiles of the laser profiler as text and as a picture, and pictures of the camera.
#pragma once

#include <span>
#include <string>

#include "firn/camera_frame_t.hpp"
#include "firn/height_profile_t.hpp"

namespace firn {

/// "row,x_mm,y_mm,z_mm" and one line a point; no z where there is no valid sample.
std::string profiles_csv(std::span<const height_profile_t> profiles);

/// Grey by height, white the highest, black where there is no valid sample; a profile a row, a single one 64
/// rows. @returns the bytes of a PNG file
std::string profiles_png(std::span<const height_profile_t> profiles);

/// @param file ends in .csv or .png @throws UsageError: another ending; std::runtime_error: cannot be written
void write_profiles(const std::string& file, std::span<const height_profile_t> profiles);

/// One picture as `file`, several as FILE-1.png, FILE-2.png …
/// @throws UsageError: `file` does not end in .png; std::runtime_error: cannot be written
void write_frames(const std::string& file, std::span<const camera_frame_t> frames);

}  // namespace firn
