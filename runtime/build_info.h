// build_commit and platform_description name the commit and the parts of the platform that the bytes may
// depend on.
#pragma once

#include <string>

namespace firn {

std::string build_commit();

/// e.g. "glibc 2.36; OpenCV 4.6.0; cpu sse4.2 avx2 fma; g++ 12.2.0". Replay names a mismatch before any
/// divergence.
std::string platform_description();

}  // namespace firn
