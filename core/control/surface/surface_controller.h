// SurfaceController computes the control action U' of the next interval of continuous deposition from a
// height map on the interval's own grid [Barnett 2012, 5.1, 5.2, 6.2]. A new scheme is one class and one row
// in the table of surface_schemes.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/control/options.h"
#include "core/grid/decision.h"
#include "core/grid/grid.h"

namespace firn::control {

/// Which quantity along the paths carries the action out.
enum class SurfaceVersion : std::uint8_t {
  kPathSpeed,       ///< c = c_nom / (1 + u') at constant valve frequency (5.7), (5.8)
  kValveFrequency,  ///< q = (1 + u') q_nom at any speed (6.3)
};
inline constexpr std::array<std::string_view, 2> kSurfaceVersionWords{"speed", "frequency"};
constexpr std::span<const std::string_view> words_of(SurfaceVersion) { return kSurfaceVersionWords; }

struct SurfaceAdaptiveOptions {
  double kp = 1.0;
  double gain = 0.33;  ///< share of an innovation that is assumed to last, at first
  double gain_min = 0.05, gain_max = 0.8;
  double gain_rate = 0.15;  ///< increase of the gain by an innovation that repeats the one before
  int window_cells = 3;     ///< innovations are compared over a square of 2 n + 1 cells
};

struct SurfaceForeseeOptions {
  double kp = 1.0;
  double flow_gain = 0.7;  ///< share of a material's mean innovation that is assumed to last
  double zone_gain = 0.3;  ///< the same of a zone's mean, beyond its material's
  double zone_mm = 1.0;    ///< width of a zone's band of distances to a border
  double wide_gain = 0.1;  ///< the same of means over squares of wide_mm, beyond the zones
  double wide_mm = 9.0;
  double narrow_gain = 1.0;  ///< share of an error narrower than narrow_mm that is corrected
  double narrow_mm = 5.0;
};
inline constexpr OptionTable kSurfaceForeseeOptions{
    Option{"kp", &SurfaceForeseeOptions::kp, "", above(0, 10), "ice, scheme smf_foresee: proportional gain",
           Change::kBetweenLayers},
    Option{"flow_gain", &SurfaceForeseeOptions::flow_gain, "", within(0, 1),
           "share of a material's unforeseen mean error that is taken for lasting", Change::kBetweenLayers},
    Option{
        "zone_gain", &SurfaceForeseeOptions::zone_gain, "", within(0, 1),
        "the same of a zone's mean, beyond its material's; a zone is a band of distances to the border of a "
        "material",
        Change::kBetweenLayers},
    Option{"zone_mm", &SurfaceForeseeOptions::zone_mm, "mm", above(0.1, 1000), "width of that band"},
    Option{"wide_gain", &SurfaceForeseeOptions::wide_gain, "", within(0, 1),
           "share of an unforeseen error wider than wide_mm, beyond its zone's mean, that is taken for "
           "lasting",
           Change::kBetweenLayers},
    Option{"wide_mm", &SurfaceForeseeOptions::wide_mm, "mm", above(0.1, 1000),
           "side of the squares it is averaged over"},
    Option{"narrow_gain", &SurfaceForeseeOptions::narrow_gain, "", within(0, 2),
           "share of an error narrower than narrow_mm that is answered", Change::kBetweenLayers},
    Option{"narrow_mm", &SurfaceForeseeOptions::narrow_mm, "mm", above(0.1, 1000),
           "side of the squares that tell narrow from wide"},
};

struct SurfaceOptions {
  std::string scheme = "smf";
  double interval_mm = 1.2;  ///< dh_m = n_d dh_d
  SurfaceVersion version = SurfaceVersion::kPathSpeed;
  double speed_range = 0.3;   ///< speed version: c stays within (1 +- this) c_nom (5.2.2)
  double output_limit = 1.0;  ///< frequency version: |U'| stays within this, at most 1
  bool feed_forward = false;  ///< of use_flow(): the action is divided by the valve's flow factor
  int last_layer = 0;         ///< of the part: its map ends the print; 0 = no last layer
  int stop_after = 0;         ///< stop when so many maps in a row saturate one material's cells; 0 = never
  double stop_share = 0.5;    ///< of them, above which a map counts
  double target_offset_mm = 0.0;  ///< of ControlOptions
  SmfGains smf;
  SurfaceAdaptiveOptions adaptive;
  SurfaceForeseeOptions foresee;
  ExtraValues extra;  ///< of the scheme's own declaration
};
inline constexpr Option kSurfaceSpeedRange{
    "speed_range", &SurfaceOptions::speed_range, "", above(0, 0.9),
    "ice: the c-controller keeps the path speed within this share of nominal [5.2.2]"};
inline constexpr Option kSurfaceVersion{
    "version", &SurfaceOptions::version, "", Range{},
    "ice: what carries the action: the path speed (c-controller) [Barnett, (5.8)] or the valve frequency "
    "(nu-controller) [(6.3)]"};
inline constexpr Option kSurfaceOutputLimit{"output_limit", &SurfaceOptions::output_limit, "", above(0, 1),
                                            "bound of the action, either sign"};
inline constexpr Option kSurfaceStopAfter{
    "stop_after",
    &SurfaceOptions::stop_after,
    "",
    within(0, 1000),
    "so many saturated intervals in a row stop the print: an empty tank, a blocked line; 0 = none do",
    Change::kBetweenLayers};
inline constexpr Option kSurfaceStopShare{
    "stop_share",
    &SurfaceOptions::stop_share,
    "",
    above(0, 1),
    "of the part's cells at their limit, above which an interval counts as saturated",
    Change::kBetweenLayers};
inline constexpr OptionTable kSurfaceOptions{kSurfaceSpeedRange, kSurfaceVersion, kSurfaceOutputLimit,
                                             kSurfaceStopAfter, kSurfaceStopShare};

/// Material of a cell of the footprint.
enum class CellMaterial : std::uint8_t { kNone = 0, kPart = 1, kScaffold = 2 };

/// The surface at one measurement plane.
struct SurfaceMeasurement {
  const HeightMap& height;             ///< [mm], finite where `material` is not kNone
  const Grid<std::uint8_t>& material;  ///< CellMaterial of each cell of the same grid
  double nominal_mm = 0.0;             ///< h_k, the required height
  int layer = 0;                       ///< deposition layers so far
  int attempt = 0;
  double noise_std_mm = 0.0;  ///< of a cell; 0 = unknown
};

/// Largest and smallest action: c = c_nom / (1 + u').
struct ActionBounds {
  double low = 0.0, high = 0.0;
};
/// Speed: [1 / (1 + range) - 1, 1 / (1 - range) - 1], so that c stays within (1 +- range) c_nom. Frequency:
/// +-output_limit.
ActionBounds action_bounds(const SurfaceOptions& options);

struct SurfaceDecision {
  using Kind = PlanDecision;
  Kind kind = Kind::kStop;
  HeightMap u;                      ///< saturated U'; two cells beyond the footprint as next to it, then 0
  double saturated_fraction = 0.0;  ///< of the footprint: cells whose action is beyond the bounds
  double rms_mm = 0.0;              ///< of height - nominal over the footprint
  double mean_error_mm = 0.0;       ///< height - nominal
  std::array<double, 2> feed_forward{1.0, 1.0};  ///< factor on each material's nominal flow that u holds
  std::string reason;
};

/// State is a pure function of the measurements and flow factors handed in. A second call for the same layer
/// replaces the first.
class SurfaceController {
 public:
  virtual ~SurfaceController() = default;
  /// @throws std::invalid_argument: sizes differ, an empty footprint, a height on it that is not finite, a
  /// layer that came before the last one.
  virtual SurfaceDecision decide(const SurfaceMeasurement& measurement) = 0;
  /// Sets each material's flow factor: flow of the valve over its calibrated flow. @throws
  /// std::invalid_argument unless above 0
  virtual void use_flow(const std::array<double, 2>& /*factor*/) {}
  /// Takes the options that may change between layers (Change::kBetweenLayers); later decisions use them.
  /// @throws std::invalid_argument naming the option, which then is as before
  virtual void use_options(const SurfaceOptions& /*options*/) {}
  /// The operator has inspected the lab: the count of saturated maps in a row starts anew.
  virtual void looked_after() {}
};

struct SurfaceScheme {
  std::string_view name;
  std::string_view meaning;
  std::unique_ptr<SurfaceController> (*make)(const SurfaceOptions&);
  std::span<const ExtraOption> extra = {};  ///< parameters of its own, [control.extra]
};
std::span<const SurfaceScheme> surface_schemes();
/// @throws std::invalid_argument: an unknown scheme (lists the known ones), an option out of its range (names
/// it).
std::unique_ptr<SurfaceController> make_surface_controller(const SurfaceOptions& options);

/// (5.7), (5.8): the path speed that lays (1 + u) times as much per length at constant flow. @pre u > -1
inline double speed_for(double nominal_mm_s, double u) { return nominal_mm_s / (1.0 + u); }

}  // namespace firn::control
