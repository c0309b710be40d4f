// experiment_of_part writes the experiment file that prints a picture or a mesh in a lab, for those who have
// a part and no experiment yet.
#pragma once

#include <filesystem>
#include <string>

namespace firn {

/// Returns true for names of pictures and meshes: .png, .jpg, .stl, .ply, .obj, .3mf.
bool names_part(const std::filesystem::path& file);

struct PartRequest {
  std::filesystem::path part;  ///< picture or mesh
  std::filesystem::path lab;   ///< file with the lab's keys
  /// Ink-jet: height of the brightest grey value, or of the mesh; ice: layers above are left out, 0 = none.
  double height_mm = 0.0;
  /// Along x; 0 = a picture is as large as 0.9 of the grid, a mesh keeps its size, if it is no larger than
  /// that. Ink-jet alone.
  double width_mm = 0.0;
};

/// Returns the text, whose paths are relative to `folder`, in which the experiment file will lie.
/// @throws UsageError: the lab prints no such part, the height is missing or cannot be; ConfigError of the
/// lab's or the part's file
std::string experiment_of_part(const PartRequest& request, const std::filesystem::path& folder);

}  // namespace firn
