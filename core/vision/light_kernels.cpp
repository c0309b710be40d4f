#include "core/vision/light_kernels.h"

namespace firn::vision {
namespace light_base {
#include "core/vision/light_loops.inc"
}  // namespace light_base

#ifdef __x86_64__
#pragma GCC push_options
#pragma GCC target("avx2")
namespace light_avx2 {
#include "core/vision/light_loops.inc"
}  // namespace light_avx2
#pragma GCC pop_options
#else
namespace light_avx2 = light_base;
#endif

const LightKernels& light_kernels(bool wide) {
  static constexpr LightKernels kBase{light_base::add_rows,    light_base::join_blocks, light_base::extremes,
                                      light_base::count_up_to, light_base::scale_by_16, light_base::cubic_row,
                                      light_base::add_line,    light_base::any_deeper};
  static constexpr LightKernels kAvx2{light_avx2::add_rows,    light_avx2::join_blocks, light_avx2::extremes,
                                      light_avx2::count_up_to, light_avx2::scale_by_16, light_avx2::cubic_row,
                                      light_avx2::add_line,    light_avx2::any_deeper};
  return wide ? kAvx2 : kBase;
}

}  // namespace firn::vision
