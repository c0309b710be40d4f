// parallel_on makes the threads that a pure core is given (core/grid/parallel.h).
#pragma once

#include "core/grid/parallel.h"

namespace firn {

/// Number of threads of --threads N: N, or all cores for N <= 0.
int thread_count(int wanted);

/// A ParallelFor on that many threads (oneTBB), of which the caller is one; 1 = serially. An exception of a
/// body reaches the caller. Calls may be nested.
ParallelFor parallel_on(int threads);

}  // namespace firn
