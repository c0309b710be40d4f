// FIRN_CLONES and has_avx2 choose, for loops that are compiled with AVX2 and without, by what the processor
// has. FIRN_INLINE marks what such loops call: it is compiled with their instruction set.
#pragma once

/// Compiles a function twice; the program chooses when it is loaded. Both give the same bytes: AVX2 has no
/// fused multiplication. Not under TSan, which instruments the choice, made before its own start, and
/// crashes.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define FIRN_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define FIRN_CLONES
#endif

#define FIRN_INLINE [[gnu::always_inline]] inline

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
