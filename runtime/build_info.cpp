#include "runtime/build_info.h"

#include <gnu/libc-version.h>

#include "firn_version.h"

namespace firn {

std::string build_commit() { return FIRN_COMMIT; }

std::string platform_description() {
  std::string cpu;
#if defined(__x86_64__)
  // The instruction sets by which glibc and OpenCV choose between variants of a function.
  __builtin_cpu_init();
  if (__builtin_cpu_supports("sse4.2")) cpu += " sse4.2";
  if (__builtin_cpu_supports("avx")) cpu += " avx";
  if (__builtin_cpu_supports("avx2")) cpu += " avx2";
  if (__builtin_cpu_supports("fma")) cpu += " fma";
  if (__builtin_cpu_supports("avx512f")) cpu += " avx512f";
#else
  cpu = " not x86-64";
#endif
  return std::string("glibc ") + gnu_get_libc_version() + "; OpenCV " + FIRN_OPENCV_VERSION + "; cpu" + cpu +
         "; compiler " + __VERSION__;
}

}  // namespace firn
