// beyond_promise tells a run of another minor version, whose byte-exact replay is not promised
// (docs/decisions/0012-replay-contract.md).
#pragma once

#include <string>
#include <string_view>

namespace firn::replay {

/// Returns a sentence that names the version and the commit that replay the run exactly; empty if the
/// versions have the same major and minor number.
/// @param recorded_version "0.2.1"; empty: of a program that had no version yet
/// @param recorded_commit as build_commit(); may end in "-dirty-DIGEST"
/// @param version of this program
std::string beyond_promise(std::string_view recorded_version, std::string_view recorded_commit,
                           std::string_view version);

}  // namespace firn::replay
