// Options of the feedback schemes: plain values, filled by config/. Each scheme checks its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace firn::control {

/// Prints the part as sliced, whatever is measured.
struct OpenLoopOptions {
  /// 0: per cell, target / (h1 + 4 h2 + 4 h3) rounded to the nearest; else that many full layers
  int layers = 0;
};

/// How a wanted height that is no whole number of droplets becomes droplets.
enum class Rounding : std::uint8_t {
  kNearest,    ///< cell by cell
  kDiffusion,  ///< the rest goes on to unvisited neighbours of the mask (Floyd-Steinberg weights, serpentine)
  kCarry,      ///< the rest is kept for the same cell's next layer
};

/// Surface-mapping feedback, drop on demand [Barnett, 5.1, 5.2.3].
struct SmfOptions {
  double kp = 1.0;
  double ki_star = 0.33;         ///< K_i* of Eq. (5.2), dimensionless
  double kd_star = 0.03;         ///< K_d* of Eq. (5.2), dimensionless
  double output_limit = 1.0;     ///< saturation planes: |U| stays within this many layers (5.2.2)
  double integral_limit = 2.0;   ///< |Ki* sum E| stays within this many layers (5.2.2)
  double layer_height_mm = 0.0;  ///< nominal layer dh; 0: h1 + 4 h2 + 4 h3
  int max_drops = 2;             ///< per cell and layer
  Rounding rounding = Rounding::kDiffusion;
};

/// Threshold feedback after Cohen and Lipson [7 of Lu 2015].
struct ThresholdOptions {
  double threshold_mm = 0.0;     ///< a cell that is short by more gets a droplet; 0: half the layer
  double layer_height_mm = 0.0;  ///< nominal layer dh; 0: h1 + 4 h2 + 4 h3
};

/// alpha of Eq. (8) from a layer on.
struct AlphaStep {
  int from_layer = 1;  ///< 1-based layer to print
  double alpha = 1.0;
};

/// How MPC searches the layer.
enum class MpcMethod : std::uint8_t {
  kGreedy,     ///< the paper's stochastic greedy search [Lu 2015, IV-C]
  kDescent,    ///< single droplets in raster order until none betters the objective
  kStripDp,    ///< exact optima of overlapping strips; for several layers, strips of each, annealing and
               ///< descent
  kCertified,  ///< one layer: strips that agree on windows (mpc/layer_solver.h); several layers: as kStripDp
};

/// What an error costs MPC.
enum class ErrorKind : std::uint8_t {
  kAbsolute,  ///< avg|e| [Lu 2015, Eq. (8)]
  kSquare,    ///< root of avg(e^2), the variance that droplets add included: few large errors
};

/// Model predictive control with stochastic greedy search [Lu 2015, Eq. (8), IV-C].
struct MpcOptions {
  MpcMethod method = MpcMethod::kGreedy;
  int strip_rows = 3;  ///< kStripDp: widest strip, 1..6
  ErrorKind error = ErrorKind::kAbsolute;
  double price_mm2 = 0.0;    ///< kSquare: variance that a droplet adds, summed over cells
  double mean_weight = 0.0;  ///< kSquare: of the square of the mean error beside the mean of squares
  int anneal_sweeps = 100;   ///< kStripDp, N > 1: sweeps over all cells and layers; 0: none
  int horizon = 1;           ///< N
  std::vector<AlphaStep> alpha = {{1, 1.0}};  ///< ascending from_layer; the first one must be 1
  int subset = 16;                            ///< M, points per random subset
  std::int64_t max_evaluations = 20'000'000;  ///< bound on single-droplet changes evaluated per decision
  int max_drops = 1;                          ///< per cell and layer; more are predicted pass by pass
  /// Initial guesses; with both, the better result counts. Dithered: as many droplets as the missing height
  /// asks for. Ones: every cell (the paper's); both take twice the time for an objective 0.1 % better.
  bool start_dithered = true;
  bool start_ones = false;
  double min_improvement_mm = 0.0;  ///< end when the best layer betters printing nothing by no more
  double finish_layers = 0.0;       ///< K of mpc/finish.h; 0: one stage
  double rim_lead_layers = 0.0;     ///< L of mpc/finish.h; 0: the inside does not wait for the rim
};

/// What is printed to learn from (core/control/pattern.h).
enum class PatternKind : std::uint8_t { kRandom, kIdentification, kSquares };
struct PatternOptions {
  PatternKind kind = PatternKind::kRandom;
  int layers = 0;          ///< 0: as many full layers as the highest cell of the target needs
  double fill = 0.5;       ///< random: probability of a droplet
  int spacing_cells = 6;   ///< identification: between centres; squares: bare cells between
  int largest_square = 6;  ///< squares: 1 x 1 up to this many droplets a side
  int square_step = 2;     ///< squares: cells from droplet to droplet; 2 shows the valleys between
  std::uint64_t seed = 1;
};

/// Marks of both nozzles (core/control/registration.h).
struct RegistrationOptions {
  int layers = 5;          ///< droplets on each mark
  int spacing_cells = 16;  ///< even: then all marks are fired in the same direction
};

struct ControlOptions {
  std::string scheme = "mpc";
  int max_layers = 0;  ///< stop for the operator when a scheme wants more layers than this; 0: no bound
  /// SMF and MPC end when a last layer would better the part by no more than this many noise_std per droplet:
  /// beyond, droplets answer the noise of the measurement (docs/algorithms-control.md has the figures).
  double noise_gate = 2.0;
  OpenLoopOptions open_loop;
  SmfOptions smf;
  ThresholdOptions threshold;
  MpcOptions mpc;
  PatternOptions pattern;
  RegistrationOptions registration;
};

}  // namespace firn::control
