// Newton's steps of fit_spline's interior-point method: the arithmetic of each iteration, four numbers side
// by side. All machines give the same bytes.
#pragma once

#include "core/motion/curve/tube_fit.h"

namespace firn::motion::tube {

/// The objective, and minus its gradient into work.step: from differences of control points, since the matrix
/// times their coordinates would be the small difference of large numbers.
double objective(TubeWork& work);

/// Newton's matrix and right-hand side for the barrier parameter mu. @pre work.step is minus the gradient
/// @param held so many control points from the first one stay, and the last one
void assemble(double mu, std::size_t held, TubeWork& work);

/// Newton's step into work.step. False: the matrix is not positive definite.
/// @pre work.band has as many rows more than unknowns as a row has entries right of its diagonal, and
/// work.step as many entries
bool solve(TubeWork& work);

/// Steps of slacks, multipliers and distances. Returns the longest step of all.
double row_steps(double mu, TubeWork& work);

struct Moved {
  double gap = 0.0, worst = 0.0;  ///< complementarity; violation of the squared radius
};
/// Moves slacks, multipliers and distances by `length` of their steps.
Moved move_rows(double length, TubeWork& work);

}  // namespace firn::motion::tube
