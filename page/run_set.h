// RunSet holds the runs that a page lists and opens: run folders, and folders of run folders.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "page/watched_run.h"
#include "runs/find/run_index.h"
#include "runs/read/run_digest.h"

namespace firn::page {

inline constexpr std::string_view kLiveRun = "live";  ///< the print that the page is part of

class RunSet {
 public:
  /// @param places run folders and folders of run folders
  /// @param live folder of the print that is called "live"; empty: none
  /// @param index file of the index of runs; empty: in memory
  /// @throws UsageError: a place that is neither
  RunSet(std::vector<std::filesystem::path> places, std::filesystem::path live,
         std::filesystem::path index = {});

  /// Returns the folder of a run by its address (runs/folder/address.h), "live", or a folder's name that one
  /// run alone has; nothing: there is no such run, or several have the name.
  std::optional<std::filesystem::path> find(const std::string& id) const;
  /// Returns the name under which a run is shown: that of its folder, and its place where others have the
  /// name.
  std::string label(const std::filesystem::path& run) const;
  /// Returns a run that is open; empty: it is not, or there is no such run.
  std::shared_ptr<WatchedRun> opened(const std::string& id);
  /// Takes a run that was read; it stays open while somebody has it, the last one longer.
  void keep(const std::shared_ptr<WatchedRun>& run);
  /// Returns the runs that somebody has.
  std::vector<std::shared_ptr<WatchedRun>> opened();

  /// Returns the work, for any thread, that writes {"runs": [...]}, newest first: it compares the index with
  /// the folders.
  /// @param where condition (runs/find/query.h); empty: all runs. The work throws runs::QueryError
  std::function<std::string()> list(const std::string& where = "");
  /// Returns the work that reads the last error of one run that the list lacks, for any thread; nothing:
  /// nobody has asked for the list, it lacks none, or the work of before goes on.
  std::function<void()> error_to_read();
  /// Returns the work, for any thread, that sums how long the lamp of a run was open in earlier runs.
  std::function<runs::LampSum()> lamp_before(const std::filesystem::path& run) const;

 private:
  struct Digests {
    std::mutex mutex;
    std::map<std::filesystem::path, runs::RunDigest> of;  // of runs that are over
    bool reading = false;

    runs::RunDigest get(const std::filesystem::path& folder);
  };
  struct Index {
    explicit Index(std::filesystem::path file) : of(std::move(file)) {}
    std::mutex mutex;
    runs::RunIndex of;
  };
  using Errors = std::map<std::filesystem::path, runs::RunDigest::Error>;
  std::vector<std::filesystem::path> folders() const;
  static std::string list_json(std::vector<std::filesystem::path> places, Index& index,
                               const std::string& where, Digests& digests, const Errors& of_opened);
  static std::vector<std::filesystem::path> folders(const std::vector<std::filesystem::path>& places,
                                                    const std::filesystem::path& live);
  static std::string label(const std::filesystem::path& run, bool others_have_the_name);

  std::vector<std::filesystem::path> places_;
  std::filesystem::path live_;
  std::map<std::filesystem::path, std::weak_ptr<WatchedRun>> opened_;
  std::shared_ptr<WatchedRun> last_;  // a tab that comes back finds it
  std::shared_ptr<Digests> digests_ = std::make_shared<Digests>();
  std::shared_ptr<Index> index_;
  bool listed_ = false;
};

}  // namespace firn::page
