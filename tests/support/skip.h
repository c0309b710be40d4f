// Reports of test cases that cannot run on this machine, which ./firn test counts as failures unless
// FIRN_ALLOW_SKIP names them.
#pragma once

#include <string>

namespace firn::test {

/// Exit status of a test program in which no test case failed and at least one was skipped; ctest's
/// SKIP_RETURN_CODE (cmake/firn.cmake).
inline constexpr int kSkippedStatus = 77;

/// Prints "skipped: NAME: REASON" and marks the running program as skipped; the caller returns from its test
/// case. @param name as in FIRN_ALLOW_SKIP: letters, digits and hyphens
void skip(const std::string& name, const std::string& reason);

}  // namespace firn::test
