#pragma once

#include "runtime/time.h"

namespace firn {

inline constexpr TimerId kDeadline{1};  ///< of the outstanding command, map or plan
inline constexpr TimerId kOperator{2};  ///< how long an accepted doubt may take to arrive after a resume
inline constexpr TimerId kAgain{3};     ///< when a refused command is given again

}  // namespace firn
