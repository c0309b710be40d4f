// ResumePoint holds the point at which an interrupted run continues, from its write-ahead files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "firn/operator_command_t.hpp"

namespace firn::runs {

struct ResumePoint {
  std::int32_t incarnation = 0;  ///< of the run that begins now
  std::int64_t offset_us = 0;    ///< behind every event of every node and of the world
  /// Newest message of each asked channel, as its publisher's write-ahead file has it.
  std::map<std::string, std::vector<std::byte>> newest;
  /// The operator's orders, each once, in the order in which they were given.
  std::vector<operator_command_t> orders;
};

/// Reads the point. @throws std::runtime_error naming the missing or damaged file
ResumePoint read_resume_point(const std::filesystem::path& run_dir,
                              const std::vector<std::string_view>& channels);

}  // namespace firn::runs
