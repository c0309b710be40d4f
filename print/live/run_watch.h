// RunWatch reads the launcher's view of a run from the bus: progress of the print, its end, cause of a stop.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "firn/fault_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/run_end_t.hpp"
#include "lcmtypes/channels.h"

namespace firn {

class RunWatch {
 public:
  explicit RunWatch(std::int32_t incarnation) : incarnation_(incarnation) {}

  static std::vector<std::string_view> channels();
  void on_message(const ChannelInfo& row, std::span<const std::byte> message);

  /// Handles a RUN_END of an earlier incarnation that its own launcher did not receive: it counts if the part
  /// was finished.
  void on_earlier_end(std::span<const std::byte> message);

  /// Returns "during layer 7, pass 0", "during layer 7, path 12", "during the scan of layer 7, path 13", or
  /// "before the first layer".
  std::string place() const;
  std::optional<layer_metrics_t> take_metrics() { return std::exchange(metrics_, std::nullopt); }
  std::vector<fault_t> take_warnings() { return std::exchange(warnings_, {}); }
  /// Returns the scheduler's notices since the last call: "the print waits before layer 7, pass 2".
  std::vector<std::string> take_notices() { return std::exchange(notices_, {}); }
  const std::optional<run_end_t>& end() const { return end_; }
  /// Returns the first fault of severity 2 or cause of a safe stop, "stage: following error"; empty: no
  /// fault.
  const std::string& fault() const { return fault_; }
  /// Returns the interlock number of that fault; 0: no fault, or it has none.
  std::int32_t fault_code() const { return fault_code_; }
  bool safe_stop() const { return safe_stop_; }

 private:
  std::int32_t incarnation_;
  int layer_ = 0, pass_ = -1;
  std::int64_t path_ = 0;  // that the arm was given last
  struct PathPlace {
    int layer = 0;
    bool measures = false;
  };
  std::map<std::int64_t, PathPlace> paths_;
  std::optional<layer_metrics_t> metrics_;
  std::vector<fault_t> warnings_;  // not taken yet
  std::optional<run_end_t> end_;
  std::vector<std::string> notices_;
  std::string fault_;
  std::int32_t fault_code_ = 0;
  bool safe_stop_ = false;
};

}  // namespace firn
