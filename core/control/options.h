// Holds the options of the feedback schemes: plain values, filled by config/. Each struct has its table of
// options beside it (core/options/option.h), which holds ranges, units and meanings; each scheme checks its
// own by that table.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/control/extra.h"
#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::control {

inline constexpr double kMaxLayers = 1e6;
inline constexpr double kMaxSeed = 9e18;  ///< below 2^63: the largest integer that a TOML file can hold

/// Prints the part as sliced, without feedback.
struct OpenLoopOptions {
  /// 0: per cell, target / (h1 + 4 h2 + 4 h3) rounded to the nearest; else that many full layers
  int layers = 0;
};
inline constexpr OptionTable kOpenLoopOptions{
    Option{"layers", &OpenLoopOptions::layers, "", within(0, kMaxLayers),
           "full layers; 0 = per cell, target height by nominal layer height"},
};

/// How a wanted height that is no whole number of droplets becomes droplets.
enum class Rounding : std::uint8_t {
  kNearest,    ///< cell by cell
  kDiffusion,  ///< the rest goes on to unvisited neighbours of the mask (Floyd-Steinberg weights, serpentine)
  kCarry,      ///< the rest is kept for the same cell's next layer
};
inline constexpr std::array<std::string_view, 3> kRoundingWords{"nearest", "diffusion", "carry"};
constexpr std::span<const std::string_view> words_of(Rounding) { return kRoundingWords; }

/// Gains of surface-mapping feedback, for droplets and for paths [Barnett, (5.1), (5.2)].
struct SmfGains {
  double kp = 1.0;
  double ki_star = 0.33;        ///< K_i* of Eq. (5.2), dimensionless
  double kd_star = 0.03;        ///< K_d* of Eq. (5.2), dimensionless
  double integral_limit = 2.0;  ///< |Ki* sum E| stays within this many layers, or intervals (5.2.2)
};
inline constexpr Option kSmfKp{
    "kp", &SmfGains::kp, "", above(0, 10), "proportional gain [Barnett, (5.1)]", Change::kBetweenLayers};
inline constexpr Option kSmfKiStar{"ki_star",
                                   &SmfGains::ki_star,
                                   "",
                                   within(0, 10),
                                   "integral gain, adjusted by (5.2)",
                                   Change::kBetweenLayers};
inline constexpr Option kSmfKdStar{"kd_star",
                                   &SmfGains::kd_star,
                                   "",
                                   within(0, 10),
                                   "derivative gain, adjusted by (5.2)",
                                   Change::kBetweenLayers};
inline constexpr Option kSmfIntegralLimit{"integral_limit",
                                          &SmfGains::integral_limit,
                                          "layers",
                                          above(0, 1000),
                                          "bound of the integral part (anti-windup)",
                                          Change::kBetweenLayers};
inline constexpr OptionTable kSmfGains{kSmfKp, kSmfKiStar, kSmfKdStar, kSmfIntegralLimit};

/// Surface-mapping feedback, drop on demand [Barnett, 5.1, 5.2.3].
struct SmfOptions : SmfGains {
  double output_limit = 1.0;     ///< saturation planes: |U| stays within this many layers (5.2.2)
  double layer_height_mm = 0.0;  ///< nominal layer dh; 0: h1 + 4 h2 + 4 h3
  int max_drops = 2;             ///< per cell and layer
  Rounding rounding = Rounding::kDiffusion;
};
inline constexpr OptionTable kSmfOptions{
    kSmfKp,
    kSmfKiStar,
    kSmfKdStar,
    Option{"output_limit", &SmfOptions::output_limit, "layers", above(0, 255),
           "bound of the output u', either sign"},
    kSmfIntegralLimit,
    Option{"layer_height_mm", &SmfOptions::layer_height_mm, "mm", within(0, 10),
           "nominal layer; 0 = h1 + 4 h2 + 4 h3"},
    Option{"max_drops", &SmfOptions::max_drops, "", within(1, 16), "droplets per cell and layer"},
    Option{"rounding", &SmfOptions::rounding, "", Range{},
           "what becomes of fractions of a droplet: dropped, spread to neighbours, kept for the next layer"},
};

/// Threshold feedback after Cohen and Lipson [7 of Lu 2015].
struct ThresholdOptions {
  double threshold_mm = 0.0;     ///< a cell that is short by more gets a droplet; 0: half the layer
  double layer_height_mm = 0.0;  ///< nominal layer dh; 0: h1 + 4 h2 + 4 h3
};
inline constexpr OptionTable kThresholdOptions{
    Option{"threshold_mm", &ThresholdOptions::threshold_mm, "mm", within(0, 10),
           "a cell that is short by more gets a droplet; 0 = half a layer", Change::kBetweenLayers},
    Option{"layer_height_mm", &ThresholdOptions::layer_height_mm, "mm", within(0, 10),
           "nominal layer; 0 = h1 + 4 h2 + 4 h3"},
};

/// alpha of Eq. (8) from a layer on.
struct AlphaStep {
  int from_layer = 1;  ///< 1-based layer to print
  double alpha = 1.0;
};
constexpr double number_of(const AlphaStep& step) { return step.alpha; }

/// How MPC searches the layer.
enum class MpcMethod : std::uint8_t {
  kGreedy,     ///< the paper's stochastic greedy search [Lu 2015, IV-C]
  kDescent,    ///< single droplets in raster order until none improves the objective
  kStripDp,    ///< exact optima of overlapping strips; for several layers, strips of each, annealing and
               ///< descent
  kCertified,  ///< one layer: dual decomposition (mpc/layer/layer_solver.h); several layers: as kStripDp
};
inline constexpr std::array<std::string_view, 4> kMpcMethodWords{"greedy", "descent", "strip_dp",
                                                                 "certified"};
constexpr std::span<const std::string_view> words_of(MpcMethod) { return kMpcMethodWords; }

/// Cost of an error in MPC.
enum class ErrorKind : std::uint8_t {
  kAbsolute,    ///< avg|e| [Lu 2015, Eq. (8)]
  kSquare,      ///< root of avg(e^2), the variance that droplets add included: few large errors
  kSquareMean,  ///< of MpcOptions: kSquare with mean_weight = kMeanWeight
};
inline constexpr double kMeanWeight = 8.0;
inline constexpr std::array<std::string_view, 3> kErrorKindWords{"absolute", "square", "square_mean"};
constexpr std::span<const std::string_view> words_of(ErrorKind) { return kErrorKindWords; }

/// Model predictive control with stochastic greedy search [Lu 2015, Eq. (8), IV-C].
struct MpcOptions {
  MpcMethod method = MpcMethod::kGreedy;
  int strip_rows = 3;  ///< kStripDp: widest strip
  ErrorKind error = ErrorKind::kAbsolute;
  double price_mm2 = 0.0;    ///< kSquare: variance that a droplet adds, summed over cells
  double mean_weight = 0.0;  ///< kSquare: of the square of the mean error beside the mean of squares
  int sweeps = 1;            ///< kCertified, one layer, alpha = 1: of the dual decomposition; 0: strips alone
  double gap = 0.0;          ///< the same: wanted (objective - bound) / objective; 0: `sweeps` alone
  int anneal_sweeps = 100;   ///< kStripDp, N > 1: sweeps over all cells and layers; 0: none
  int horizon = 1;           ///< N
  std::vector<AlphaStep> alpha = {{1, 1.0}};  ///< ascending from_layer; the first one must be 1
  int subset = 16;                            ///< M, points per random subset
  std::int64_t max_evaluations = 20'000'000;  ///< bound on single-droplet changes evaluated per decision
  int max_drops = 1;                          ///< per cell and layer; more are predicted pass by pass
  /// Initial guesses; with both, the better result counts. Dithered: as many droplets as the missing height
  /// requires. Ones: every cell (the paper's); both take twice the time for an objective 0.1 % better.
  bool start_dithered = true;
  bool start_ones = false;
  double min_improvement_mm = 0.0;  ///< end when the best layer improves on printing nothing by no more
  double outside_price = 0.0;       ///< of height beside the part, against height that is missing in it
  double rise_layers = 0.0;      ///< of mpc/edge_reference.h; 0: every layer is planned for the whole target
  double edge_lag_layers = 0.0;  ///< the same; 0: the edge does not lag
  double finish_layers = 0.0;    ///< K of mpc/reference_governor.h; 0: one stage
  double rim_lead_layers = 0.0;  ///< L of mpc/reference_governor.h; 0: the inside does not wait for the rim
};
inline constexpr OptionTable kMpcOptions{
    Option{
        "method", &MpcOptions::method, "", Range{},
        "greedy: the paper's stochastic search [Lu 2015, IV-C]; descent: the same single droplets in raster "
        "order; strip_dp: exact optima of overlapping strips, for horizon > 1 strips of each layer and "
        "annealing: the best; certified: one layer near the optimum by dual decomposition (sweeps, gap), "
        "several as "
        "strip_dp"},
    Option{"strip_rows", &MpcOptions::strip_rows, "rows", within(1, 6),
           "strip_dp: widest strip; one row more costs about six times the time"},
    Option{"sweeps", &MpcOptions::sweeps, "", within(0, 1000),
           "certified, one layer, alpha = 1: sweeps of the dual decomposition; each finds a layer and a "
           "bound; 0 = "
           "strips alone"},
    Option{"gap", &MpcOptions::gap, "", within(0, 1),
           "certified, one layer, alpha = 1: sweeps go on, up to a hundred or control.mpc.sweeps if that is "
           "more, until "
           "at most this share of the objective could be saved; 0 = control.mpc.sweeps alone. The layer's "
           "reason says "
           "what was reached"},
    Option{"anneal_sweeps", &MpcOptions::anneal_sweeps, "", within(0, 1e6),
           "strip_dp with horizon > 1: sweeps of annealing over all cells and layers; 0 = none"},
    Option{"horizon", &MpcOptions::horizon, "layers", within(1, 8), "N of [Lu 2015, (8)]"},
    Option{"error", &MpcOptions::error, "", Range{},
           "what an error costs: absolute: its mean, as in (8); square: its root mean square, with the "
           "variance that droplets add (control.droplet_scatter); square_mean: the same and eight times the "
           "square of the part's mean error"},
    Option{"alpha", &MpcOptions::alpha, "", above(0, 1),
           "weight of the mean error against the roughness in (8); a number, or [{from_layer = 1, alpha = "
           "1.0}, ...]",
           Change::kBetweenLayers},
    Option{"subset", &MpcOptions::subset, "cells", within(1, 4096),
           "M: points tried together in the greedy search [Lu 2015, IV-C]"},
    Option{"max_evaluations", &MpcOptions::max_evaluations, "", within(1, 1e12),
           "bound of the work per decision", Change::kBetweenLayers},
    Option{"max_drops", &MpcOptions::max_drops, "", within(1, 8), "droplets per cell and layer"},
    Option{"finish_layers", &MpcOptions::finish_layers, "layers", within(0, 20),
           "the part is first printed to so many layers below its target, its rim too, and only then "
           "finished; 0 = in one stage"},
    Option{"outside_price", &MpcOptions::outside_price, "", within(0, 1000),
           "what a layer pays for ink beside the part, at alpha = 1: um of error inside for each um of "
           "height outside; 0 = nothing"},
    Option{"rise_layers", &MpcOptions::rise_layers, "layers", within(0, 2),
           "until the part is nearly finished each layer is planned for a target so many layers above its "
           "mean height, so "
           "that no cell rises ahead of the others; 0 = for the whole target"},
    Option{"edge_lag_layers", &MpcOptions::edge_lag_layers, "layers", within(0, 10),
           "with rise_layers: a cell at the outline lags behind by so many layers for each of its sides that "
           "lies "
           "outside, so that the inside gives it ink and gets none"},
    Option{"min_improvement_mm", &MpcOptions::min_improvement_mm, "mm", within(0, 10),
           "the print ends when the best layer would improve the surface by no more", Change::kBetweenLayers},
};

/// rim_lead_layers with control.droplet_factors = "together".
inline constexpr double kRimLead_layers = 1.5;

/// Patterns for system identification (core/control/pattern.h).
enum class PatternKind : std::uint8_t { kRandom, kIdentification, kSquares, kPlaces };
inline constexpr std::array<std::string_view, 4> kPatternKindWords{"random", "identification", "squares",
                                                                   "places"};
constexpr std::span<const std::string_view> words_of(PatternKind) { return kPatternKindWords; }

struct PatternOptions {
  PatternKind kind = PatternKind::kRandom;
  int layers = 0;                  ///< 0: as many full layers as the highest cell of the target needs
  double fill = 0.5;               ///< random: probability of a droplet
  int spacing_cells = 6;           ///< identification, places: between centres; squares: bare cells between
  int largest_square = 6;          ///< squares: 1 x 1 up to this many droplets a side
  OnOff one_by_one = OnOff::kOff;  ///< identification: each droplet of a site is cured before the next
  int square_step = 2;             ///< squares: cells from droplet to droplet; 2 shows the valleys between
  std::uint64_t seed = 1;
};
inline constexpr OptionTable kPatternOptions{
    Option{"kind", &PatternOptions::kind, "", Range{}, "what scheme pattern prints [Lu 2015, III-A, V-C]"},
    Option{"layers", &PatternOptions::layers, "", within(0, kMaxLayers),
           "patterns; 0 = as many full layers as the highest cell needs"},
    Option{"fill", &PatternOptions::fill, "", above(0, 1), "random: probability of a droplet"},
    Option{"spacing_cells", &PatternOptions::spacing_cells, "cells", within(1, 4096),
           "identification, places: between centres; squares: bare ground between"},
    Option{"one_by_one", &PatternOptions::one_by_one, "", Range{},
           "identification: each droplet of a site is a layer of its own, cured before the next"},
    Option{"largest_square", &PatternOptions::largest_square, "droplets", within(1, 64),
           "squares: 1 x 1 up to this many a side"},
    Option{"square_step", &PatternOptions::square_step, "cells", within(1, 4096),
           "squares: from droplet to droplet"},
    Option{"seed", &PatternOptions::seed, "", within(0, kMaxSeed), "random: of the patterns"},
};

/// Marks of both nozzles (core/control/registration.h).
struct RegistrationOptions {
  int layers = 5;          ///< droplets on each mark
  int spacing_cells = 16;  ///< even: then all marks are fired in the same direction
};
inline constexpr OptionTable kRegistrationOptions{
    Option{"layers", &RegistrationOptions::layers, "", within(1, 1000),
           "droplets on each mark of a registration print"},
    Option{"spacing_cells", &RegistrationOptions::spacing_cells, "cells", within(4, 4096),
           "between marks; those of the two nozzles alternate"},
};

struct ControlOptions {
  std::string scheme = "mpc";
  int max_layers = 200;  ///< stop for the operator when a scheme wants more layers than this
  /// SMF and MPC end when a last layer would better the part by no more than this many noise_std per droplet:
  /// beyond, droplets answer the noise of the measurement (docs/algorithms/control.md has the figures).
  double noise_gate = 2.0;
  int stall_layers = 6;  ///< MPC ends when so many layers have bettered the part by no more than noise
  double target_offset_mm = 0.0;  ///< schemes with feedback aim so far above the target
  double rim_inset = 0.0;         ///< of rim_inset.h: open loop, SMF, threshold
  OpenLoopOptions open_loop;
  SmfOptions smf;
  ThresholdOptions threshold;
  MpcOptions mpc;
  PatternOptions pattern;
  RegistrationOptions registration;
  ExtraValues extra;  ///< of the scheme's own declaration
};
inline constexpr Option kControlMaxLayers{"max_layers",
                                          &ControlOptions::max_layers,
                                          "",
                                          within(1, kMaxLayers),
                                          "the print stops for the operator beyond this",
                                          Change::kBetweenLayers};
inline constexpr Option kControlNoiseGate{
    "noise_gate",
    &ControlOptions::noise_gate,
    "",
    within(0, 100),
    "SMF and MPC end when a layer would better the part by no more than this many sensor sigmas per droplet",
    Change::kBetweenLayers};
inline constexpr Option kControlStallLayers{
    "stall_layers",
    &ControlOptions::stall_layers,
    "layers",
    within(0, 1000),
    "MPC ends when so many layers have bettered the part by no more than the measurement's noise; 0 = never",
    Change::kBetweenLayers};
inline constexpr Option kControlRimInset{
    "rim_inset", &ControlOptions::rim_inset, "", within(0, 0.5),
    "open_loop, smf and threshold: share of the pitch by which droplets of cells at the outline land inside "
    "of their middles, at the nearest place of actuation.offsets; mpc chooses places itself, certified among "
    "the middle "
    "and this one"};
inline constexpr Option kControlTargetOffset{
    "target_offset_mm",
    &ControlOptions::target_offset_mm,
    "mm",
    within(-10, 10),
    "schemes with feedback aim so far above the target; errors are still reported about the target itself",
    Change::kBetweenLayers};
inline constexpr OptionTable kControlOptions{kControlMaxLayers, kControlNoiseGate, kControlStallLayers,
                                             kControlRimInset, kControlTargetOffset};

}  // namespace firn::control
