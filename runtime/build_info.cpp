#include "runtime/build_info.h"

#include <gnu/libc-version.h>

#include <fstream>
#include <span>
#include <sstream>

#include "files/digest.h"
#include "firn_version.h"

namespace firn {

std::string build_version() { return FIRN_VERSION; }

std::string build_name() {
  const std::string commit = FIRN_COMMIT, date = FIRN_COMMIT_DATE;
  if (date.empty()) return "firn " + build_version() + " (without a commit)";
  const std::string changed = build_commit().substr(commit.size());
  return "firn " + build_version() + " (" + commit.substr(0, 12) + changed + ", " + date + ")";
}

std::string build_commit() {
  const std::string commit = FIRN_COMMIT;
  return std::string(FIRN_DIFF).empty() ? commit : commit + "-dirty-" + build_sources().substr(0, 12);
}

std::string build_sources() { return FIRN_SOURCES; }

BuildDiff build_diff() {
  const std::string digest = FIRN_DIFF;
  if (digest.empty()) return {};
  const std::string path = std::string(FIRN_DIFF_FOLDER) + "/" + digest + ".diff";
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  BuildDiff diff{text.str(), {}};
  if (!in || sha256_hex(std::as_bytes(std::span(diff.text))) != digest)
    return {{}, path + ": is missing or was changed since the build"};
  return diff;
}

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
