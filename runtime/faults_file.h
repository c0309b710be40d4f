// FaultsFile writes nodes/<node>.faults: the faults of the lossy bus for this node over all incarnations,
// so that a test can read them even after kill -9.
#pragma once

#include <cstdint>
#include <filesystem>

#include "runtime/lossy.h"

namespace firn {

class FaultsFile {
 public:
  /// Goes on from the counts that stand in the file. @param on false: never written
  FaultsFile(std::filesystem::path path, bool on);
  void write(const LossyCounts& counts);
  void write_sometimes(const LossyCounts& counts, std::int64_t wall_us);  ///< at most every 100 ms

 private:
  std::filesystem::path path_;
  bool on_;
  LossyCounts before_;
  std::int64_t next_us_ = 0;
};

}  // namespace firn
