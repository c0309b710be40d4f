// build_version, build_commit, build_sources and platform_description name the version, the commit, the
// sources and the parts of the platform that the bytes may depend on.
#pragma once

#include <string>

namespace firn {

/// Returns the version of Firn, e.g. "1.0.0".
std::string build_version();

/// Returns the program, its version, the first twelve digits of its commit and the commit's day, e.g.
/// "firn 1.0.0 (6b981fd6a3c1, 2026-11-30)"; after the digits "-dirty-DIGEST" of sources that differ from it.
std::string build_name();

/// Returns the commit, or "COMMIT-dirty-DIGEST" of a tree that differs from it. DIGEST begins
/// build_sources().
std::string build_commit();

/// Returns the SHA-256 over every source and the compiler's flags, 64 hexadecimal digits. Equal builds have
/// equal sources, whatever the commit.
std::string build_sources();

/// The difference (git's) between the commit and the sources of this build. Both are empty for a clean build.
struct BuildDiff {
  std::string text;
  std::string missing;  ///< why there is no text: the build folder's file was removed or changed
};
BuildDiff build_diff();

/// e.g. "glibc 2.36; OpenCV 4.6.0; cpu sse4.2 avx2 fma; g++ 12.2.0". Replay names a mismatch before any
/// divergence.
std::string platform_description();

}  // namespace firn
