// check_truth compares the true surfaces in a run's log with the digests in the world's own record.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace firn::runs {

struct TruthCheck {
  std::vector<std::string> differs;  ///< "log.lcm, byte 812: SIM_TRUTH 3 is not what the world told"
  std::vector<std::string> notes;    ///< truth that nothing can be compared with
  std::int64_t compared = 0;         ///< messages that are what the world told
};

/// Compares every SIM_TRUTH of log.lcm, with or without its index, with world.rec: content and order.
/// @throws record::FileError
TruthCheck check_truth(const std::filesystem::path& run);

}  // namespace firn::runs
