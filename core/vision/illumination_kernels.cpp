#include "core/vision/illumination_kernels.h"

namespace firn::vision {
namespace illumination_base {
#include "core/vision/illumination_loops.inc"
}  // namespace illumination_base

#ifdef __x86_64__
#pragma GCC push_options
#pragma GCC target("avx2")
namespace illumination_avx2 {
#include "core/vision/illumination_loops.inc"
}  // namespace illumination_avx2
#pragma GCC pop_options
#else
namespace illumination_avx2 = illumination_base;
#endif

const IlluminationKernels& illumination_kernels(bool wide) {
  static constexpr IlluminationKernels kBase{illumination_base::add_rows,    illumination_base::join_blocks,
                                             illumination_base::extremes,    illumination_base::count_up_to,
                                             illumination_base::scale_by_16, illumination_base::cubic_row,
                                             illumination_base::add_line,    illumination_base::any_deeper};
  static constexpr IlluminationKernels kAvx2{illumination_avx2::add_rows,    illumination_avx2::join_blocks,
                                             illumination_avx2::extremes,    illumination_avx2::count_up_to,
                                             illumination_avx2::scale_by_16, illumination_avx2::cubic_row,
                                             illumination_avx2::add_line,    illumination_avx2::any_deeper};
  return wide ? kAvx2 : kBase;
}

}  // namespace firn::vision
