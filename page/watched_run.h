// WatchedRun holds one run as the page shows it: its facts, its rows, its maps; live or recorded. A run that
// is over is read from its log, one that prints (or whose log has gaps) from its write-ahead files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "page/run_maps.h"
#include "page/run_view.h"
#include "page/view_json.h"
#include "runs/folder/run_meta.h"
#include "runs/read/run_reader.h"

namespace firn {
struct Product;
}

namespace firn::page {

class WatchedRun {
 public:
  /// Reads the messages so far. @throws UsageError, std::invalid_argument: no run folder, or an unreadable
  /// one
  WatchedRun(const Product& product, std::filesystem::path folder, double now_s);
  WatchedRun(const WatchedRun&) = delete;
  WatchedRun& operator=(const WatchedRun&) = delete;

  struct News {
    std::vector<std::string> frames;  ///< JSON, for every tab
    bool map = false;                 ///< there is a map of another layer
  };
  /// Reads new messages. @param now_s of a steady clock
  News poll(double now_s);

  /// Returns the JSON of "hello" and of "state". @param label of RunSet @param may_resume of Answers
  std::string hello(double now_s, const std::string& label, bool may_resume, const Reader& reader) const;
  std::string state(double now_s) const;

  /// Returns the frame of a map; nothing: there is none.
  std::optional<std::vector<std::byte>> map(const MapRequest& request) { return maps_->frame(request); }
  /// As of RunMaps.
  std::uint64_t rows_stamp() const { return maps_->rows_stamp(); }
  std::optional<std::vector<std::byte>> partial_map(std::uint64_t since) const {
    return maps_->partial(since);
  }
  std::optional<int> newest_layer() const { return maps_->newest_layer(); }

  /// Returns true if the run has this alarm (page/alarms.h).
  bool has_alarm(const std::string& text) const;
  const std::filesystem::path& folder() const { return folder_; }
  std::int64_t run_id() const { return run_id_; }
  bool live() const { return live_; }
  /// Returns RMS and mean error of the last layer [um].
  std::optional<std::pair<double, double>> last_error_um() const;

 private:
  void open_reader();
  void make_view();
  void take_values();  // that are computed from maps
  void look_for_the_end(double now_s);
  void look_at_notes(News& news);

  const Product& product_;
  std::filesystem::path folder_;
  std::int64_t run_id_ = 0;
  std::map<std::string, std::string> texts_;  // of the provenance
  runs::RunMeta meta_;
  Experiment experiment_;
  std::string trouble_;                                  // of the experiment's text
  std::map<std::string, std::filesystem::path> inputs_;  // by role
  std::optional<runs::RunReader> reader_;
  std::optional<RunMaps> maps_;
  std::optional<RunView> view_;
  bool live_ = false;
  double looked_s_ = -1e9;
  std::uintmax_t notes_bytes_ = 0;  // of the file, which only grows
};

}  // namespace firn::page
