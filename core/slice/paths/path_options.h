// PathOptions holds the options of path planning. Defaults: those of the Cobra 600 [Barnett, 3.3, 3.5, 3.7,
// Table 3-1].
#pragma once

#include <cstdint>

#include "core/geometry/region.h"
#include "core/options/option.h"

namespace firn::slice {

enum class FillPattern : std::uint8_t {
  kConcentric,  ///< rings at growing distances inside the outline, until nothing is left [3.5, Fig. 3-7b]
  kLines,       ///< ZZFILL: parallel lines, not linked [3.5]
  kZigzag,      ///< parallel lines, linked along the outline where neighbours allow it [3.5, Fig. 3-7a]
  kNone,        ///< boundaries only
};

/// The start point of a closed path.
enum class SeamPlacement : std::uint8_t {
  kNearest,  ///< at the point nearest to the nozzle
  kAligned,  ///< at the point furthest towards -y (then -x), above each other in all layers
  kRandom,   ///< by seed, layer and path
};

/// Options of the extrusion lines of one material.
struct ExtrusionOptions {
  double first_offset_mm = 0.6;    ///< outline to the centre of the outermost path: 0.6 water, 1.2 SME [3.7]
  double boundary_width_mm = 1.5;  ///< [3.7]
  double fill_width_mm = 3.0;      ///< fill spreads and may be wider [3.7]
  double gap_mm = 0.75;  ///< voids wider than this between rings get lines of their own; 0: no such lines
  int boundaries = 1;    ///< boundary paths side by side, boundary_width apart
  FillPattern pattern = FillPattern::kConcentric;
  double fill_angle_rad = 0.0;                ///< direction of lines and zigzags in odd layers
  double fill_turn_rad = 1.5707963267948966;  ///< added in even layers
  bool operator==(const ExtrusionOptions&) const = default;
};
inline constexpr OptionTable kExtrusionRings{
    Option{"first_offset_mm", &ExtrusionOptions::first_offset_mm, "mm", within(0, 100),
           "outline to the centre of the outermost path [3.7]"},
    Option{"boundary_width_mm", &ExtrusionOptions::boundary_width_mm, "mm", above(0, 100),
           "of boundary paths"},
    Option{"boundaries", &ExtrusionOptions::boundaries, "", within(1, 1000), "boundary paths side by side"},
};
inline constexpr Option kExtrusionFillWidth{"fill_width_mm", &ExtrusionOptions::fill_width_mm, "mm",
                                            above(0, 100), "of fill paths, which may spread [3.7]"};
inline constexpr Option kExtrusionGap{
    "gap_mm", &ExtrusionOptions::gap_mm, "mm", within(0, 100),
    "wider spots between rings, and thin parts, get beads of their own width; 0: none do"};
inline constexpr ExtrusionOptions kWater{};
inline constexpr ExtrusionOptions kSme{.first_offset_mm = 1.2};

enum class Support : std::uint8_t {
  kNone,
  kFull,      ///< below everything and around everything [3.3]
  kOverhang,  ///< below surfaces that lean outward by more than an angle, and around nothing else
};

struct SupportOptions {
  Support kind = Support::kFull;
  double buffer_mm = 3.3;                    ///< outward growth of the area above [Table 3-1]
  double overhang_rad = 0.7853981633974483;  ///< kOverhang: from the vertical; steeper walls need no support
  bool operator==(const SupportOptions&) const = default;
};
inline constexpr Option kSupportBuffer{"buffer_mm", &SupportOptions::buffer_mm, "mm", within(0, 1000),
                                       "outward growth of what lies above [Table 3-1]"};

/// Ice paths that anchor the scaffold [3.7, Fig. 3-8].
struct HookOptions {
  bool on = false;
  int two_from_layer = 10;  ///< layers 1..10: the outermost scaffold path is ice; 11..20: the two outermost
  int last_layer = 20;
  double clearance_mm = 1.5;  ///< scaffold is extended until hook and part are this far apart, line to line
  bool operator==(const HookOptions&) const = default;
};
inline constexpr OptionTable kHookOptions{
    Option{"two_from_layer", &HookOptions::two_from_layer, "", within(0, 1e6),
           "one path up to this layer, two above"},
    Option{"last_layer", &HookOptions::last_layer, "", within(0, 1e6), "no hook above"},
    Option{"clearance_mm", &HookOptions::clearance_mm, "mm", within(0, 1000),
           "extra scaffold outward until hook and part are so far apart"},
};

/// Paths of the laser above the finished layer [Table 3-1, M frame].
struct MeasureOptions {
  bool on = false;
  std::uint8_t material = 0;
  double spacing_mm = 2.0;  ///< between scan lines
  double angle_rad = 0.0;
  double inset_mm = 0.6;    ///< distance from the outline
  double laser_x_mm = 0.0;  ///< laser spot seen from the nozzle; paths are moved by its opposite
  double laser_y_mm = 0.0;
  bool operator==(const MeasureOptions&) const = default;
};
inline constexpr double kPathRange_mm = 1e5;
inline constexpr Option kMeasureSpacing{"spacing_mm", &MeasureOptions::spacing_mm, "mm", above(0, 1000),
                                        "between scan lines"};
inline constexpr OptionTable kMeasurePlace{
    Option{"inset_mm", &MeasureOptions::inset_mm, "mm", within(0, 1000), "stay so far inside the outline"},
    Option{"laser_x_mm", &MeasureOptions::laser_x_mm, "mm", within(-kPathRange_mm, kPathRange_mm),
           "laser spot seen from the nozzle; 0, 0 where firn plan knows the tool"},
    Option{"laser_y_mm", &MeasureOptions::laser_y_mm, "mm", within(-kPathRange_mm, kPathRange_mm),
           "the same along y"},
};

struct PathOptions {
  ExtrusionOptions part = kWater;  ///< every material but the scaffold
  ExtrusionOptions scaffold = kSme;
  SupportOptions support{};
  HookOptions hook{};
  MeasureOptions measure{};
  /// Maximum distance of a path from its exact position (arc, offset of the given region). 0: the rounding of
  /// the grid, arcs within 1 um.
  double chord_tolerance_mm = 0.05;
  SeamPlacement seam = SeamPlacement::kNearest;
  std::uint64_t seed = 1;   ///< random seams
  int two_opt_passes = 2;   ///< over a layer's order; 0 = nearest neighbour only
  double start_x_mm = 0.0;  ///< position of the nozzle before each layer
  double start_y_mm = 0.0;
  bool operator==(const PathOptions&) const = default;
};
inline constexpr OptionTable kPathOrder{
    Option{"seed", &PathOptions::seed, "", within(0, 9e18), "of random seams"},
    Option{"two_opt_passes", &PathOptions::two_opt_passes, "", within(0, 100),
           "over the order of a layer's paths; 0 = nearest neighbour only"},
    Option{"start_x_mm", &PathOptions::start_x_mm, "mm", within(-kPathRange_mm, kPathRange_mm),
           "where the nozzle waits before each layer"},
    Option{"start_y_mm", &PathOptions::start_y_mm, "mm", within(-kPathRange_mm, kPathRange_mm),
           "the same along y"},
};
/// @throws std::invalid_argument naming the option that is out of its range
void check(const PathOptions& options);

/// Share of the chord tolerance of a job for PATHFILTER; rings drawn from its outlines have the rest, so that
/// they meet the tolerance against the contours of the mesh: blunt corners move by at most 1.06 times the
/// distance of the outline, and sharper ones are corrected (cusp_corrector.h).
inline constexpr double kOutlineShare = 0.4;
inline constexpr double kRingShare = 1.0 - 1.06 * kOutlineShare;

inline constexpr std::uint8_t kPartMaterial = 0;
inline constexpr std::uint8_t kScaffoldMaterial = 1;

}  // namespace firn::slice
