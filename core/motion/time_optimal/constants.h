// Holds the constants of the speed profile, the lower bound and the proof, each with its unit and its reason.
// A value without another reason was measured by the benches of docs/measurements.md (motion_paths,
// certified_bench): with it random paths need the fewest iterations.
#pragma once

#include <cstddef>

namespace firn::motion {

// --- Interior-point method of the profile (jerk_profile.cpp)

/// Share of the way to the boundary of slacks and multipliers that a step goes.
inline constexpr double kToBoundary = 0.96;
/// Centring parameter sigma: at the start, minimum, maximum.
inline constexpr double kFirstCentring = 0.34, kMinCentring = 0.065, kMaxCentring = 0.9;
/// Gap over violation, as shares of the duration: the gap is not closed faster than the violation.
inline constexpr double kGapPerViolation = 0.023;
/// A relative violation counts beside the gap after division by this: the motion is slowed down by a third of
/// it, jerk being of third order.
inline constexpr double kViolationDivisor = 3.0;
/// Duration from which the gap is absolute [s]: a relative one would allow a visible loss near a rest.
inline constexpr double kLongMotion_s = 3.0;
/// Gap plus violation below which inactive limits are checked first, and the ratio from which they are
/// activated.
inline constexpr double kFirstActivation = 0.1, kActivationRatio = 1.0;

// --- The discrete problem and its first guess (profile_problem.cpp)

/// Product of the first multiplier and slack over the cell's duration.
inline constexpr double kFirstProduct = 0.175;
/// First slack where a limit is exceeded, over the limit.
inline constexpr double kMinFirstSlack = 0.42;
/// Excess of the jerk inside a cell over that at its ends, over bend^2, where b'' is a straight line over
/// b^(-1/2).
inline constexpr double kJerkBulge = 0.3125;
/// 3 / 2^(3/2): rate of y = b^(3/4) from a rest under constant jerk, over sqrt(jerk).
inline constexpr double kRestGrowth = 1.0606601717798212;
/// Share of that growth which the guess assumes, and factor of the guessed b.
inline constexpr double kGuessedGrowth = 0.8, kGuessedSquare = 0.86;
/// Share of the jerk limit that v^3 |q'''| may use in the guess.
inline constexpr double kGuessedThirdShare = 0.41;
/// Half of the length over which the guessed y is averaged, in y / sqrt(jerk): where speeding up turns into
/// slowing down, the guess would otherwise require many times the jerk limit.
inline constexpr double kGuessRounding = 0.35;
/// Elements at both ends of the solver's arrays that are zero: as many as a band reaches beyond them.
inline constexpr std::size_t kZeroEdge = 6;

/// Cells behind the start of a profile that goes on from another, over which its limits are widened, and by
/// which share at the start: the other solver stopped while it exceeded them by less.
inline constexpr std::size_t kJoinCells = 16;
inline constexpr double kJoinRoom = 1e-3;

// --- Lower bound (speed_bound.cpp)

/// Curvature below which the path is straight for the jerk across it [1/mm].
inline constexpr double kMinCurvature = 1e-9;
/// Speed between two samples over that at them: joints may allow more there.
inline constexpr double kBetweenSamples = 1.0005;
/// Steps of the fixed-point iteration from above for the speed that jerk allows; a bound after any number.
inline constexpr int kJerkSteps = 3;
/// Steps of Newton's method and relative change that ends it; relative step inside of low <= high.
inline constexpr int kReachSteps = 40;
inline constexpr double kReachClose = 1e-6, kReachInside = 1e-9;
/// The same with the jerk across the path: false position takes over, from a gap above a guess that was too
/// low, which widens by a factor.
inline constexpr int kBentSteps = 30;
inline constexpr double kBentClose = 5e-4, kBentFirstGap = 1e-4, kBentGapGrowth = 20.0;
/// A guess so much above the end of b is the answer.
inline constexpr double kGuessAbove = 2e-4;

// --- Bounds at every instant (motion_bounds.cpp)

/// Rounds of dividing intervals, and maximum number of parts in one of them.
inline constexpr int kMaxDivisionRounds = 8;
inline constexpr double kMaxIntervalParts = 8.0;
/// Parts of an interval over which the arm has no bound: it is too long.
inline constexpr std::size_t kUnboundedParts = 4;

}  // namespace firn::motion
