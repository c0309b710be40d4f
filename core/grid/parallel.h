// ParallelFor computes independent pieces of work on the caller's threads: core code owns no threads.
#pragma once

#include <functional>

namespace firn {

/// Calls body(i) once for each i in [0, n), in any order, perhaps at the same time, and returns when all are
/// through. Bodies write to places of their own, so that the result is the same for any number of threads.
using ParallelFor = std::function<void(int n, const std::function<void(int)>& body)>;

/// One after the other, on the caller's thread.
inline void serially(int n, const std::function<void(int)>& body) {
  for (int i = 0; i < n; ++i) body(i);
}

}  // namespace firn
