// Holds the constants of the certified planner, each with its unit and its reason. Where the reason is a
// measurement, it is a choice by the benches of docs/measurements.md (motion_paths, certified_bench).
#pragma once

#include <cstddef>

namespace firn::motion {

// --- Distances between curve and path (deviation_limits.h)

/// sqrt(2): rounding of both coordinates by e moves a point by at most e times this.
inline constexpr double kDiagonal = 1.4142135623730951;
/// Radius of the tube about held points over the distance within which they are held: room for the distance
/// that the interior-point method may leave them by.
inline constexpr double kHeldRadiusShare = 0.99;
/// Maximum radius of the tube between two held points over max_deviation_mm(): a curve at the tube's edge
/// passes the final check with room to spare.
inline constexpr double kBetweenShare = 0.9;

// --- Curve of one shape (segment_curve.cpp)

/// Tries to bring a curve inside its allowed deviation; each one plans the curve anew.
inline constexpr int kMaxDeviationTries = 10;
/// Tries, the first of those above, that also bring held points within their rounding.
inline constexpr int kMaxHoldTries = 6;
/// Share of the allowed distance that the next try aims at, for held points and for the deviation.
inline constexpr double kHoldAim = 0.95, kDeviationAim = 0.98;
/// Limits of the factor by which one try reduces a distance; the deviation does not shrink in proportion.
inline constexpr double kMinReduction = 0.1, kMaxReduction = 0.9;
/// The same of a tube, whose curve follows its radius more closely.
inline constexpr double kMaxTubeReduction = 0.98;
/// A curve whose reduction is above this leaves the tolerance slightly: shorter ramps are tried before chords
/// are held to their sagitta.
inline constexpr double kSlightReduction = 0.6;
/// Factor of the held sagitta where interpolated vertices of uneven chords leave the tolerance.
inline constexpr double kSagittaReduction = 0.2;
/// Reductions after which the ramp itself is too long, the factor by which it is shortened, and its minimum
/// [mm], that of PlanOptions::curvature_ramp_mm.
inline constexpr int kReductionsOfFullRamp = 2;
inline constexpr double kRampReduction = 0.6;
inline constexpr double kMinRamp_mm = 0.01;

// --- Speed along a curve (speed_planner.cpp)

/// Cells of the fast tier are divided into so many where a tolerance is used without slack: there the time
/// depends on where the cells fall.
inline constexpr double kToleranceSplit = 2.0;
/// Relative duality gap where a tolerance is used without slack, and where descent compares motions.
inline constexpr double kToleranceGap = 0.003, kDescentGap = 0.0015;
/// Slow tier: growth of cells beside a rest, first cell [mm], division of cells, minimum cell [mm] (letters
/// have samples some micrometres apart, their speed changes over tens of micrometres), gap, iterations of the
/// solver, instants checked inside each piece. Converged: halving the cells changes the time by under 0.05 %.
inline constexpr double kOptimalRestGrowth = 1.04, kOptimalRest_mm = 0.01, kOptimalSplit = 8.0,
                        kOptimalMinCell_mm = 5e-4, kOptimalGap = 1e-4;
inline constexpr int kOptimalIterations = 80, kOptimalInnerChecks = 2;
/// Instants checked inside each piece of the closed form on a line, which has few pieces.
inline constexpr int kStraightInnerChecks = 3;
/// Attempts on one curve, each on finer cells; from the second on the gap is smaller by this factor.
inline constexpr int kMaxAttempts = 4;
inline constexpr double kRetryGapFactor = 0.25;
/// A profile whose motion must be slowed down by more than this was given up by the solver.
inline constexpr double kSolvedFactor = 1.5;
/// A motion so many times slower than the best so far, without a solution: finer cells will not help.
inline constexpr double kHopelessFactor = 1.5;
/// Factor of time above which a cell is divided for the next attempt.
inline constexpr double kCellFactor = 1.002;
/// Factor of time up to which slowing down is cheaper than another attempt.
inline constexpr double kAcceptedFactor = 1.006;
/// Rounding of the factor of a closed form that keeps every limit.
inline constexpr double kClosedFormRounding = 1e-9;
/// Shares of a joint's rate, and of its acceleration and jerk, that the tool's motion may ask of it before
/// the joint's limits are active constraints from the beginning.
inline constexpr double kInactiveRateShare = 0.97, kInactiveShare = 0.8;
/// Excess of an inactive limit between the knots from which all limits are made active.
inline constexpr double kInactiveExcess = 1.0005;
/// Minimum of the first cell at rest [mm]; below it knots lose digits.
inline constexpr double kMinRestCell_mm = 1e-4;
/// Share of v^(3/2) / j^(1/2), the length on which jerk j reaches the speed v from rest, for that cell.
inline constexpr double kRestCellShare = 0.5;
/// Relative sharpness of the bounds of time scaling (motion_bounds.h): of the fast tier, and where the
/// tolerance or the slow tier pays for it.
inline constexpr double kFastSharpness = 3e-4, kFineSharpness = 3e-5;

// --- Windows of a long curve (speed_windows.cpp)

/// Cells up to which a curve is planned as a whole; cells of a window at first, and up to which it grows
/// where it is all stopping. Each cell takes 3.6 kB of buffers.
inline constexpr std::size_t kMaxWholeCells = 16000, kWindowCells = 8000, kMaxWindowCells = 256000;
/// Relative duality gap of a window: a path of many windows has the sum of their gaps.
inline constexpr double kWindowGap = 5e-4;
/// The end of a window that is planned anew in the next one: so many times the way of stopping from its
/// largest speed, and cells at least.
inline constexpr double kWindowStops = 4.0;
inline constexpr std::size_t kMinOverlapCells = 64;
/// Share of the overlap over which the next window's first guess follows the motion of the one before.
inline constexpr double kFollowedShare = 0.5;

// --- Descent of the time inside the tube (curve_descent.cpp)

/// Radii of the tubes whose fits are tried besides the widest: minimum [mm], ratio, maximum share of the
/// allowed deviation.
inline constexpr double kMinFitRadius_mm = 0.003, kFitRadiusRatio = 3.0, kMaxFitRadiusShare = 0.7;
/// Tries to bring a fit inside the tolerance.
inline constexpr int kMaxNarrowings = 10;
/// Rounds of descent: from each of two starts, from the better one, and on the slow tier's cells.
inline constexpr int kTrialRounds = 24, kDescentRounds = 96, kLastRounds = 8;
/// Failed rounds one after another that end descent.
inline constexpr int kMaxFailures = 6;
/// Relative gain of a round below which it counts as failed.
inline constexpr double kMinGain = 3e-5;
/// Share of the allowed distance by which a step that left it is to stay below it.
inline constexpr double kStepMargin = 0.01;
/// Division of cells when the curve is found.
inline constexpr double kLastSplit = 2.0;
/// Share of the weights of |change of r'''|^2 at the start, and its factors after a slower and a faster step.
inline constexpr double kFirstWeight = 2.0, kWeightGrowth = 2.0, kWeightDecay = 0.8;
/// Minimum weight over that of the fastest place: cells at rest may not move freely.
inline constexpr double kMinWeight = 1e-5;
/// Share of jerk / v^3 that |r'''| is taken to have at least, where the limit of the jerk is not reached.
inline constexpr double kMinThirdShare = 0.6;
/// Slowing down by so much between the profile's knots does not count when curves are compared: it depends on
/// where the knots fall.
inline constexpr double kForgivenFactor = 0.006;

// --- Shapes of a segment (shape_choice.cpp)

/// A motion this much over the minimum time on a straight line of the same length is not compared with other
/// shapes.
inline constexpr double kAcceptedOverStraight = 1.002;
/// Maximum duration for a motion that is planned without comparison [s].
inline constexpr double kNoMaxDuration_s = 1e300;
/// Chords from which the points may be samples of a free-form curve: of rounded samples, and of held ones.
inline constexpr std::size_t kMinFreeChords = 6, kMinHeldChords = 3;
/// Maximum median chord of held samples [mm]; farther points are no samples of a curve.
inline constexpr double kMaxHeldChord_mm = 5.0;
/// Third derivative of a curve through rounded points, about 8 noise / chord^3, over their mean chord's
/// [1/mm^2]: half of the value that a jerk of 4000 mm/s^3 allows at 125 mm/s.
inline constexpr double kMinRoundingBend = 1e-3, kRoundingBend = 8.0;
/// Share of the points on recognised lines and arcs from which a path is not free-form.
inline constexpr double kRecognisedShare = 0.5;

// --- Stops (stop_choice.cpp)

/// Cosine of the turn from which a corner is never rolled: 154 degrees.
inline constexpr double kRollableCosine = -0.9;
/// Path on either side of a corner on which rolling is tried: minimum and maximum [mm], and between them so
/// many times the way that stopping costs.
inline constexpr double kMinTrial_mm = 2.0, kMaxTrial_mm = 15.0, kTrialStops = 3.0;
/// Length of a curve within the tolerance over its polygon's, at least, where time is saved by it.
inline constexpr double kRolledLength = 0.98;
/// Distance of two points that are one [mm].
inline constexpr double kSamePoint_mm = 1e-9;
/// Cosine of the turn of a step that goes back or aside by no more than its points' rounding.
inline constexpr double kStepBackCosine = 0.5;
/// Share of the held distance up to which such a step is rounding.
inline constexpr double kStepBackShare = 0.95;
/// Share of the allowed deviation within which a polygon with rests at its vertices is thinned: another such
/// share is left to the motion between them.
inline constexpr double kThinningShare = 0.45;

// --- Corners (path_corners.cpp)

/// Tangent of half of kMaxSampledTurn: chords of an arc turn by less.
inline constexpr double kMaxHalfTurnTangent = 0.4228;
/// Turn of the neighbours of a vertex over its own, at least, where all three are samples of an arc.
inline constexpr double kMinNeighbourTurn = 0.3;
/// Distance within which a path is thinned before its corners are sought: roundings of a coordinate, and
/// share of the tolerance.
inline constexpr double kThinningNoises = 1.5, kCornerThinningShare = 1.0 / 16.0;
/// Roundings of a coordinate that a corner's turn must reach over.
inline constexpr double kCornerReachNoises = 10.0;

// --- Emission (emission.cpp, certified.cpp)

/// Every so many points decide the arm configuration of a path with at least four times as many.
inline constexpr std::size_t kConfigurationStride = 16;
/// Minimum tick [s]: differences of closer samples show the rounding of their values.
inline constexpr double kMinTick_s = 1e-5;
/// Relative slowing down that covers the rounding of sums of the motion's derivatives.
inline constexpr double kDerivativeRounding = 4e-9;
/// Ticks, or almost so many, that a motion must save to be emitted as a faster one.
inline constexpr double kFewerTicks = 0.999;
/// Tries to slow the emitted samples down to their limits.
inline constexpr int kMaxEmissionTries = 4;

}  // namespace firn::motion
