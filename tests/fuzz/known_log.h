// The log beside the packed files of fuzz_packed and of its seeds.
#pragma once

#include <string_view>

namespace firn::fuzz {

inline constexpr std::string_view kKnownLog = "a log that the seeds know: sixteen bytes and more, and more";

}  // namespace firn::fuzz
