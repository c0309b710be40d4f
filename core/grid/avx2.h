// Tells whether the processor has AVX2, for loops that are compiled with it and without.
#pragma once

namespace firn {

inline bool has_avx2() {
#ifdef __x86_64__
  static const bool supported = __builtin_cpu_supports("avx2");
  return supported;
#else
  return false;
#endif
}

}  // namespace firn
