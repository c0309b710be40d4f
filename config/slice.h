// SliceSettings holds the settings of firn slice as read from a file (experiments/slicing/gear.toml). Keys:
// docs/slice-settings.md, written from the table in slice_fields.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/fields.h"
#include "core/slice/mesh/placement.h"
#include "core/slice/mesh/slicer.h"
#include "core/slice/paths/path_options.h"

namespace firn {

/// Settings of one material's nozzle: the extrusion options, and the words of the file.
struct BeadSettings {
  slice::ExtrusionOptions bead;
  std::string fill = "concentric";
  double angle_deg = 0.0, turn_deg = 90.0;
  std::string tool;  ///< of the machine that plans the paths; empty = the flange
};

struct GcodeSettings {
  double boundary_mm_s = 50.0, fill_mm_s = 50.0, travel_mm_s = 100.0;
  double filament_mm = 1.75;      ///< E counts mm of filament of this diameter; 0 = mm^3
  double x_mm = 0.0, y_mm = 0.0;  ///< added to all coordinates
  std::string start, end;         ///< further lines, '|' between them
};

/// Settings of a job, with the Cobra 600's defaults [Barnett 2012, Table 3-1, 3.3, 3.5, 3.7].
struct SliceSettings {
  std::string unit = "mm";
  std::string facet_count = "agree";
  std::vector<double> scale{1, 1, 1}, rotation_deg{0, 0, 0}, rotation_order{1, 2, 3};
  std::array<std::string, 3> place{"as_is", "as_is", "number"};
  std::array<std::vector<double>, 3> place_mm{
      {{0}, {0}, {0}}};              ///< per mesh; the last holds for all further ones
  std::vector<double> materials{0};  ///< per mesh, as place_mm
  slice::SliceOptions contour;       ///< layer height and chord tolerance are the job's
  BeadSettings part{{}, "concentric", 0.0, 90.0, "water"};
  BeadSettings scaffold{slice::kSme, "concentric", 0.0, 90.0, "scaffold"};
  std::string support = "full";
  double overhang_deg = 45.0;
  slice::PathOptions paths;  ///< with part, scaffold and the words filled in by path_options()
  std::string seam = "nearest";
  std::int32_t hook = 0, measure = 0, measured_material = 0;
  double measure_angle_deg = 0.0;
  std::string laser_tool = "laser";
  std::int32_t coverage = 0;
  double coverage_pitch_mm = 0.1;
  GcodeSettings gcode;
};

/// Returns every field, in the order of the documentation.
std::vector<Field> slice_fields(SliceSettings& settings);

/// @param overrides "KEY=VALUE", after the text. @throws ConfigError naming file, line, key, value and limit;
/// for an unknown key the nearest known one
SliceSettings parse_slice_settings(const std::string& toml_text, const std::string& file_name,
                                   const std::vector<std::string>& overrides = {});
/// An empty path gives the defaults.
SliceSettings load_slice_settings(const std::filesystem::path& path,
                                  const std::vector<std::string>& overrides = {});

/// Returns every key with its value, as TOML that reads back to the same settings.
std::string dump(SliceSettings settings);
/// Returns the documentation of all keys.
std::string slice_markdown();

// Conversions to the types of core/slice.
/// @param mesh its number in the job, from 0; @param file_unit_mm of files that name their unit; 0 = no unit
/// named
slice::Placement placement(const SliceSettings& settings, std::size_t mesh, double file_unit_mm = 0.0);
std::uint8_t material_of(const SliceSettings& settings, std::size_t mesh);
slice::PathOptions path_options(const SliceSettings& settings);

}  // namespace firn
