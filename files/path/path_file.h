// read_paths reads paths to plan, one after another, from a CSV, JSON, G-code, SVG or DXF file
// (docs/commands/plan.md) or from a sliced job (docs/formats.md). Memory holds one path, one layer, or one
// drawing, not the job.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/motion/kinematics/limits.h"
#include "core/path/given_curve.h"

namespace firn {

/// Endings of the files' names, by which they are told apart.
inline constexpr std::string_view kLayerFileEndings[] = {".paths"};
inline constexpr std::string_view kGcodeEndings[] = {".gcode", ".nc", ".ngc", ".g", ".gco", ".cnc", ".tap"};

/// One path of a file with the planner's further inputs: tool, yaw, speed limits.
struct InputPath {
  std::int64_t number = 0;  ///< in the file, from 1
  std::string place;        ///< for messages: "job.csv:17" or "job.json: paths[3]"
  Path path;
  std::string tool = "flange";
  double yaw_rad = 0.0;               ///< of the tool, constant along the path
  std::vector<double> yaw_point_rad;  ///< instead: one per point; empty = yaw_rad
  motion::PathSpeedLimit speed_limit;
  std::vector<GivenCurve> given;  ///< among the points, ascending
  double fraction = 0.0;          ///< of the file read so far, this path included, 0 to 1
};

/// Receives each path in order, and notes: sentences about contents of the file that no path shows.
class PathSink {
 public:
  template <std::invocable<InputPath&&> Take>
  PathSink(Take take) : take_(std::move(take)) {}
  PathSink(std::function<void(InputPath&&)> take, std::function<void(const std::string&)> note,
           std::function<void(double mm)> travelled = nullptr)
      : take_(std::move(take)), note_(std::move(note)), travelled_(std::move(travelled)) {}

  void operator()(InputPath&& path) const { take_(std::move(path)); }
  void note(const std::string& sentence) const {
    if (note_) note_(sentence);
  }
  /// The length of all moves between the paths, once, of a format that has such moves.
  void travelled(double mm) const {
    if (travelled_) travelled_(mm);
  }

 private:
  std::function<void(InputPath&&)> take_;
  std::function<void(const std::string&)> note_;
  std::function<void(double mm)> travelled_;
};

/// Reads a *.csv, *.json, *.gcode (*.nc, *.ngc, *.g, *.gco, *.cnc, *.tap), *.svg, *.dxf or *.paths file.
/// @throws UsageError naming the file, line or key (for an unknown one the nearest known), and the limit:
/// coordinates within +-100 m, yaws within
/// +-20 turns, speeds above 0, 4 million points in one path, 1000 bytes in one CSV line; of a *.paths file
/// the byte
void read_paths(const std::filesystem::path& file, const PathSink& sink);

/// Read the same formats from any stream; `size` in bytes (for the fraction), `name` for messages.
void read_paths_csv(std::istream& in, const std::string& name, double size, const PathSink& sink);
void read_paths_json(std::istream& in, const std::string& name, double size, const PathSink& sink);
/// G-code: G1, G2, G3 (I J or R), G5 in G17, with G20, G21, G90, G91, G90.1, G91.1, G92 and F (a speed
/// limit). Where moves bear E, only those with a growing E deposit; where M3, M4 or S switch a beam, only
/// those with it on. Any other move, G4, G28, G30, G53 and stops (M0, M1, M2, M6, M30, M60) end a path; the
/// first move after G28, G30, G53 or G38 only places the tool. Commands of the firmware (M104, START_PRINT)
/// are passed over and noted. `in` is read twice. @throws for any other G code, other axes, parameters,
/// subprograms, and for a height that changes along a path
void read_paths_gcode(std::istream& in, const std::string& name, double size, const PathSink& sink);
/// SVG: each subpath of the shapes that are filled or stroked, whatever the colour, with transforms,
/// viewports, <use> and units; y upwards from the page's lower edge. Style sheets with names, .classes and
/// #ids decide as in a browser. @throws also for text and images that are seen, for another selector that
/// decides which shapes are drawn, and for a clip-path that cuts or a mask
void read_paths_svg(std::istream& in, const std::string& name, double size, const PathSink& sink);
/// DXF (ASCII): LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE (with bulges), SPLINE and INSERT of the
/// model space in $INSUNITS, on layers that are plotted, neither off nor frozen; curves of one layer whose
/// ends meet are one path (files/path/join_curves.h). Entities without curves, such as HATCH and TEXT, are
/// passed over and noted.
/// @throws also for any other entity, for a block that is not in the file, and for a plane that is not z =
/// constant
void read_paths_dxf(std::istream& in, const std::string& name, double size, const PathSink& sink);
/// Reads the paths of a sliced job, each with its material's tool.
void read_paths_layers(const std::filesystem::path& file, const PathSink& sink);

inline constexpr double kMaxCoordinate_mm = 1e5, kMaxYaw_deg = 7200.0;
inline constexpr std::size_t kMaxPathPoints = 4000000;

}  // namespace firn
