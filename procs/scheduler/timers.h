// TimerIds of the scheduler: the loops share them.
#pragma once

#include "runtime/time.h"

namespace firn {

inline constexpr TimerId kDeadline{1};   ///< of the outstanding command, map or plan
inline constexpr TimerId kOperator{2};   ///< maximum wait for an accepted doubt after a resume
inline constexpr TimerId kAgain{3};      ///< repetition of a refused command
inline constexpr TimerId kPurge{4};      ///< end of a purge
inline constexpr TimerId kGasSteady{5};  ///< ink flows evenly from then on

}  // namespace firn
