// LabLock keeps a second print away from the same instruments and the same bus.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn {
struct Experiment;
}

namespace firn::runs {

class RunFolder;

/// Holds one locked file for each address: the folder of the run's instruments (RUN/io), each instrument that
/// RUN/io links to elsewhere, and a bus that the user named. Simulated labs of two runs share no address. The
/// system gives the locks back when the last process that inherited them has ended, however it ended.
class LabLock {
 public:
  enum class Heirs {
    kNobody,   ///< the lock ends with this process
    kChildren  ///< processes that are started later hold it too: drivers that still make the lab safe
  };
  /// Waits up to 5 s for the processes of a launcher that has died.
  /// @param bus_url empty: a port of the run's own, which nobody shares
  /// @throws UsageError naming the address, the other's process and its run folder; record::FileError
  LabLock(const RunFolder& run, const Experiment& experiment, const std::string& bus_url, Heirs heirs);
  ~LabLock();
  LabLock(const LabLock&) = delete;
  LabLock& operator=(const LabLock&) = delete;

 private:
  struct Held {
    std::filesystem::path file;
    int fd = -1;
  };
  void take(const std::filesystem::path& file, const std::string& address, mode_t mode);
  void release();

  std::string run_;
  Heirs heirs_;
  std::vector<Held> held_;
};

}  // namespace firn::runs
