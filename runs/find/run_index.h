// RunIndex finds runs among many folders: an index of the folders in SQLite. It is never the truth:
// it follows the folders at each use, and may be removed at any time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runs/find/query.h"

namespace firn::runs {

struct FoundRun {
  std::filesystem::path folder;
  std::string listing;  ///< run_listing_text()
};

struct FindOptions {
  std::string sort = "started";  ///< key; runs without it come last
  bool descending = false;
  std::size_t limit = 0;  ///< 0: all
};

struct IndexReport {
  std::size_t runs = 0, read = 0, gone = 0;  ///< in the places; read anew; removed since
};

class RunIndex {
 public:
  using Progress = std::function<void(double fraction)>;
  /// @param file of the index, made where it is missing; empty: in memory
  /// @param note is told that a damaged index is made anew
  explicit RunIndex(std::filesystem::path file, std::function<void(const std::string&)> note = {});
  ~RunIndex();
  RunIndex(const RunIndex&) = delete;
  RunIndex& operator=(const RunIndex&) = delete;

  /// Compares the index with the folders and reads the runs that have changed. Two processes may do so at
  /// once.
  /// @param places folders of run folders, or run folders
  /// @throws UsageError: a place that is no folder
  IndexReport refresh(const std::vector<std::filesystem::path>& places, const Progress& progress = {});

  /// Returns the runs of the places that meet a condition, as of the last refresh().
  /// @param text of the query, for errors @throws QueryError: a key that no run can have
  std::vector<FoundRun> find(const Query& query, std::string_view text,
                             const std::vector<std::filesystem::path>& places,
                             const FindOptions& options = {});

 private:
  class Database;
  template <class Work>
  auto repaired(Work work);

  std::filesystem::path file_;
  std::function<void(const std::string&)> note_;
  std::unique_ptr<Database> database_;
};

/// Returns the file of this user's index: FIRN_INDEX, else $XDG_CACHE_HOME or ~/.cache, firn/runs.sqlite.
std::filesystem::path user_index();

}  // namespace firn::runs
