// The loops of Newton's steps, compiled for the base instruction set and for AVX2.
#include "core/motion/curve/tube_newton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace firn::motion::tube {

namespace base {
#include "core/motion/curve/tube_loops.inc"
}  // namespace base

#ifdef __x86_64__
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#include "core/motion/curve/tube_loops.inc"
}  // namespace avx2
#pragma GCC pop_options

static bool wide() {
  static const bool supported = __builtin_cpu_supports("avx2");
  return supported;
}
#else
namespace avx2 = base;
static bool wide() { return false; }
#endif

double objective(TubeWork& work) { return wide() ? avx2::objective(work) : base::objective(work); }

void assemble(double mu, TubeWork& work) { wide() ? avx2::assemble(mu, work) : base::assemble(mu, work); }

bool solve(TubeWork& work) { return wide() ? avx2::solve(work) : base::solve(work); }

double row_steps(double mu, TubeWork& work) {
  return wide() ? avx2::row_steps(mu, work) : base::row_steps(mu, work);
}

Moved move_rows(double length, TubeWork& work) {
  return wide() ? avx2::move_rows(length, work) : base::move_rows(length, work);
}

}  // namespace firn::motion::tube
