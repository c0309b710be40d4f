// The loops of Newton's steps, compiled for the base instruction set and for AVX2.
#include "core/motion/curve/tube_newton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "core/grid/avx2.h"

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
#else
namespace avx2 = base;
#endif

double objective(TubeWork& work) { return has_avx2() ? avx2::objective(work) : base::objective(work); }

void assemble(double mu, TubeWork& work) { has_avx2() ? avx2::assemble(mu, work) : base::assemble(mu, work); }

bool solve(TubeWork& work) { return has_avx2() ? avx2::solve(work) : base::solve(work); }

double row_steps(double mu, TubeWork& work) {
  return has_avx2() ? avx2::row_steps(mu, work) : base::row_steps(mu, work);
}

Moved move_rows(double length, TubeWork& work) {
  return has_avx2() ? avx2::move_rows(length, work) : base::move_rows(length, work);
}

}  // namespace firn::motion::tube
