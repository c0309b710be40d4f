// Holds the constants of the curves that are followed, each with its unit and its reason. Where the reason is
// a measurement, it is a choice by the benches of docs/measurements.md (motion_paths).
#pragma once

#include <cstddef>
#include <limits>

namespace firn::motion {

// --- Lines and arcs among the points (curve_pieces.cpp)

/// Points within this distance of one line or circle are one piece [mm]; that is also the bound of the
/// displacement by recognition (in addition to the arc's own sagitta over its chords, at most kSagittaMm).
/// Above the rounding of files with 5 decimals.
inline constexpr double kRecogniseMm = 2e-5;
/// Maximum sagitta of an arc over the chords between its points [mm]: longer chords are a polygon.
inline constexpr double kSagittaMm = 0.03;
/// Turn from which four points on a circle are an arc [rad]; four points of a smooth curve may lie on one by
/// chance.
inline constexpr double kMinArcTurn_rad = 0.5;
/// Length from which three points on a line are a line [mm], for the same reason.
inline constexpr double kMinLine_mm = 2.0;
/// Length of a run that is recognised whatever follows it [mm]: a smooth curve that stays within kRecogniseMm
/// of a circle for so long has hardly a change of curvature.
inline constexpr double kLongRun_mm = 4.0;
/// Distance of the second point beyond a run up to which it is still on the run, and from which the run has
/// ended abruptly [mm]: a smooth curve has left its osculating circle by 16 kRecogniseMm there.
inline constexpr double kSameRun_mm = 2.0 * kRecogniseMm, kAbruptEnd_mm = 50.0 * kRecogniseMm;
/// Distance of two pieces that are tangent [mm]: either is off by kRecogniseMm, and their joint, too.
inline constexpr double kTangency_mm = 3.0 * kRecogniseMm;
/// Halvings of the first chord of a Bezier curve: 2^-12 of a sample interval is below every cell.
inline constexpr int kMaxHalvings = 12;
/// Turn from which a given arc becomes two pieces [rad]: just below half a turn, beyond which its end points
/// do not determine its side.
inline constexpr double kMaxArcPiece_rad = 3.0;
/// A C2 spline leaves a jump u of curvature by u h^2 / 27 at cells of h beside it, and a turn t of the
/// tangent by t h / 10; u h^2 / 41 between equal cells, more where they grow.
inline constexpr double kJumpDivisor = 27.0, kTurnDivisor = 10.0;
/// Chords in a row from which short chords are a sampled curve.
inline constexpr std::size_t kMinDenseChords = 8;
/// Distance by which a spline may leave a given curve [mm]: a tenth of a micrometre, below every machine's
/// repeatability.
inline constexpr double kExactMm = 1e-4;
/// Sagitta of the chords that stand for a given curve where deviations are measured [mm]; maximum number of
/// them for one sample interval, which may have a larger sagitta; half of the step of the parameter by which
/// a degenerate tangent is differenced.
inline constexpr double kGivenSagittaMm = 2e-6, kMaxGivenChords = 64.0, kTangentStep = 1e-4;

// --- Ramps and knots of the recognised curve (path_curve.cpp, path_knots.cpp)

/// Chords shorter than so many ramps are dense: their vertices are interpolated.
inline constexpr double kDenseWidths = 2.0;
/// Share of the held distance that the spline may leave its base by at joints: the rest is for vertices that
/// are not knots.
inline constexpr double kHeldJointShare = 0.5;
/// Turn [rad] and jump of curvature [1/mm] below which a joint is smooth: rounding.
inline constexpr double kSmoothTurn = 1e-9, kSmoothJump = 1e-12;
/// Distance from the cubic through its neighbours up to which a vertex of a dense polygon is no knot [mm].
inline constexpr double kSmoothVertex_mm = 5e-4;
/// Relative difference of neighbouring chords up to which they are evenly spaced.
inline constexpr double kUnevenChords = 0.05;
/// Maximum length between two knots on vertices [mm].
inline constexpr double kMaxVertexSpacing_mm = 2.0;
/// Spacing where a mark has no wish [mm].
inline constexpr double kAnySpacing_mm = std::numeric_limits<double>::max();
/// Error of the spline in a cell on a given arc, R angle^4 / 384 [mm]: cells half as long again stay within a
/// nanometre.
inline constexpr double kArcCellError_mm = 4e-8;
/// Way beside a segment on which its speed limit holds, too [mm]: room for the displacement by recognition.
inline constexpr double kSpeedLimitMargin_mm = 0.5;

// --- Tube about the polyline (tube_fit.cpp)

/// Radius of a tube's places over TubeOptions::radius_mm, where the polygon is meant: a curve leaves the tube
/// between two places.
inline constexpr double kTubePlaceRadius = 0.96;
/// Share of the radius within which the polyline is thinned for the tube's middle line.
inline constexpr double kLineThinning = 1.0 / 16.0;
/// Share of the radius within which it is thinned for the sizes of the cells; of held samples, each of which
/// has a radius of its own.
inline constexpr double kCellThinning = 0.25, kSampleCellThinning = 1.0;
/// Largest cell times turn at a vertex, in radii.
inline constexpr double kCellTurn = 2.5;
/// Cells over thinned chords, at most; of held samples there are more knots than points.
inline constexpr double kCellChords = 1.2, kSampleCellChords = 0.5;
/// Cell length over that which the tube alone needs: time has features of its own, and coarser cells make it
/// depend on where they happen to lie. For a curve that stays, and for one that descent moves.
inline constexpr double kCellShare = 0.4, kMovedCellShare = 0.28;
/// Rounds of halving cells that cannot hold their samples.
inline constexpr int kMaxSplits = 6;
/// Growth of a cell over the distance to a shorter one.
inline constexpr double kCellGrowth = 0.35;
/// Rounds in which a cell's length and the size at its middle agree to a percent.
inline constexpr int kCellRounds = 3;
/// Cells of a curve, at least.
inline constexpr double kMinCells = 8.0;
/// Distance of two places of the tube in cells.
inline constexpr double kPlaceSpacing = 0.5;
/// Maximum reduction of the tube where the polygon misses its curve by about the tolerance.
inline constexpr double kMissedReduction = 0.25;
/// Share of the tube on chords that are lines, and the way from their ends where it is whole [mm].
inline constexpr double kLineShare = 0.1, kLineEnd_mm = 2.0;
/// Distance from a rest on which the weight of |r'''|^2 falls [mm], and the minimum weight.
inline constexpr double kRestReach_mm = 0.05, kMinRestWeight = 1e-8;
/// Cells to either side of a place where the curve is outside, on which the spline there depends.
inline constexpr std::size_t kDependentCells = 2;

// --- Interior-point method of the tube (tube_spline.cpp, tube_newton.cpp)

/// Cells of a window of a long spline, and cells beyond those that are kept of it.
inline constexpr std::size_t kTubeWindowCells = 4000, kTubeOverlapCells = 200;
inline constexpr int kMaxTubeIterations = 40;
/// Gap that ends the iteration, over the objective; where points are held, one tight turn may be all of the
/// objective, and the rest of the path has to be smooth beside it.
inline constexpr double kTubeGap = 0.03, kSampleTubeGap = 1e-4;
/// Gap at the start, over the objective; where points are held, the first steps near their centres are long
/// ones, whatever the turns.
inline constexpr double kFirstTubeGap = 0.3, kFirstSampleTubeGap = 100.0;
/// The same of a step of descent, over the function's value: shares of the objective grow with its weights,
/// and push a curve that hardly moves away from the tube's edge.
inline constexpr double kStepGap = 2e-5, kFirstStepGap = 0.003;
/// Violation of a squared radius that ends the iteration, over it.
inline constexpr double kTubeViolation = 0.005;
/// Slack of a place that the guess leaves outside, over its squared radius.
inline constexpr double kMinTubeSlack = 0.05;
/// Gradient of the Lagrangian that ends the iteration, over the first one.
inline constexpr double kStationary = 1e-2;
/// Centring parameter: at the start, minimum, maximum; the share of the gap that a violation keeps.
inline constexpr double kFirstTubeCentring = 0.3, kMinTubeCentring = 0.05, kMaxTubeCentring = 0.9,
                        kViolationCentring = 0.2;
/// Share of the way to the boundary of slacks and multipliers that a step goes.
inline constexpr double kTubeToBoundary = 0.95;
/// Penalty of the least squares over the objective per place, its growth from try to try, that of both ends
/// over the diagonal, and tries.
inline constexpr double kFirstPenalty = 100.0, kPenaltyGrowth = 30.0, kEndPenalty = 1e9;
inline constexpr int kMaxPenalties = 8;

// --- Held samples (held_samples.cpp)

/// Maximum turn between the chords of samples [rad]; more is a corner.
inline constexpr double kMaxSampledTurn = 0.8;
/// Radii between the ends of the points that give a step its direction, and their maximum number to either
/// side.
inline constexpr double kDirectionRadii = 4.0;
inline constexpr int kMaxDirectionPoints = 32;
/// Cosine above which a step beside an end, whose direction is rounded, is forward.
inline constexpr double kForwardCosine = -0.25;
/// Share of the steps' own lengths that is added: no two points have the same parameter.
inline constexpr double kOwnLengthShare = 1e-3;
/// A chord is a line if it is so many times longer than one beside it and at least so long [mm]; longer than
/// kMaxSampleChord_mm it is no sample interval in any case.
inline constexpr double kLineOverNeighbour = 4.0, kMinLineChord_mm = 0.8, kMaxSampleChord_mm = 5.0;
/// Length beyond a chord on which points are looked at, over the chord's.
inline constexpr double kLookAhead = 0.5;
/// Range of the turn at a chord's end over half of its length times the curvature beyond it: 1 for a sample
/// interval of a curve, 0 for a line, more at a corner.
inline constexpr double kMinContinuation = 0.25, kMaxContinuation = 3.0;
/// Bulge of a curve between two samples over the sagitta of the arc that turns as the polygon does.
inline constexpr double kBulgeFactor = 2.0;
/// Turn over that at the other end below which a chord's end is straight.
inline constexpr double kStraightEnd = 0.2;

// --- Deviation (frechet.cpp)

/// The bound exceeds the largest distance within the correspondence by at most this factor and length [mm].
inline constexpr double kDeviationSharpness = 1.01, kDeviationSharpness_mm = 1e-6;
/// Divisions of a cubic: each is sharper by 4.
inline constexpr int kMaxDivisions = 12;
/// Newton's steps to the place nearest to a vertex; where distances of held points are wanted.
inline constexpr int kNewtonSteps = 4, kPreciseNewtonSteps = 20;
/// Change of the parameter that ends Newton's method, over the chord.
inline constexpr double kNearestChange = 1e-4, kPreciseNearestChange = 1e-9;
/// Maximum length of a curve over the chord that the next guess assumes, and minimum |r'|.
inline constexpr double kMaxStretchGuess = 1.02, kMinParameterSpeed = 1e-3;
/// 1 / (12 sqrt 3): a cubic leaves its parabola by at most so much of its third difference.
inline constexpr double kCubicOverParabola = 0.048113;

}  // namespace firn::motion
