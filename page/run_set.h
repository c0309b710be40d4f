// RunSet holds the runs that a page lists and opens: run folders, and folders of run folders.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "page/run_digest.h"
#include "page/watched_run.h"

namespace firn::page {

class RunSet {
 public:
  /// @param places run folders and folders of run folders
  /// @param live folder of the print that is called "live"; empty: none
  /// @throws UsageError: a place that is neither
  RunSet(std::vector<std::filesystem::path> places, std::filesystem::path live);

  /// Returns the folder of a run; nothing: there is no such run.
  std::optional<std::filesystem::path> find(const std::string& id) const;
  /// Returns a run that is open; empty: it is not, or there is no such run.
  std::shared_ptr<WatchedRun> opened(const std::string& id);
  /// Takes a run that was read; it stays open while somebody has it, the last one longer.
  void keep(const std::shared_ptr<WatchedRun>& run);
  /// Returns the runs that somebody has.
  std::vector<std::shared_ptr<WatchedRun>> opened();

  /// Returns {"runs": [...]}, newest first.
  std::string list_json();
  /// Returns the work that reads the last error of one run that the list lacks, for any thread; nothing:
  /// nobody has asked for the list, it lacks none, or the work of before goes on.
  std::function<void()> error_to_read();
  /// Returns the work, for any thread, that sums how long the lamp of a run was open in earlier runs.
  std::function<LampSum()> lamp_before(const std::filesystem::path& run) const;

 private:
  struct Digests {
    std::mutex mutex;
    std::map<std::filesystem::path, RunDigest> of;  // of runs that are over
    bool reading = false;

    RunDigest get(const std::filesystem::path& folder);
  };
  std::vector<std::filesystem::path> folders() const;

  std::vector<std::filesystem::path> places_;
  std::filesystem::path live_;
  std::map<std::filesystem::path, std::weak_ptr<WatchedRun>> opened_;
  std::shared_ptr<WatchedRun> last_;  // a tab that comes back finds it
  std::shared_ptr<Digests> digests_ = std::make_shared<Digests>();
  bool listed_ = false;
};

}  // namespace firn::page
