// DiskFaults makes the system calls of this process that write below a folder fail, one after the other. The
// calls are those of the C library, replaced in the test's program; link disk_faults.cpp.
#pragma once

#include <cstdint>
#include <filesystem>

namespace firn::test {

class DiskFaults {
 public:
  static constexpr std::uint64_t kNever = 0;

  /// @param fails number of the call that fails with "no space left on device", from 1; kNever: calls are
  /// counted @param stays every later call fails too
  DiskFaults(const std::filesystem::path& folder, std::uint64_t fails, bool stays = false);
  ~DiskFaults();
  DiskFaults(const DiskFaults&) = delete;
  DiskFaults& operator=(const DiskFaults&) = delete;

  std::uint64_t calls() const;  ///< that write below the folder, so far
};

}  // namespace firn::test
