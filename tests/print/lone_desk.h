// LoneDesk is the desk of a print that does nothing but take orders, and say that it waits.
#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "print/operator/operator_desk.h"

namespace firn::test {

class LoneDesk {
 public:
  /// Makes `run` a run folder of this number.
  LoneDesk(const std::filesystem::path& run, std::int64_t run_id) {
    std::filesystem::create_directories(run / "nodes");
    std::ofstream(run / "experiment.toml") << "\n";
    std::ofstream(run / "provenance.json") << "{\"run_id\": " << run_id << "}\n";
    desk_.emplace(run, run_id, Experiment(), [](const std::string&) {});
    thread_ = std::thread([this] {
      while (!over_) {
        desk_->wait(5);
        desk_->service([this](const OperatorOrder& order, const std::string&) {
          {
            const std::lock_guard lock(mutex_);
            orders_.push_back(to_text(order));
          }
          if (order.verb == OperatorVerb::kStop) desk_->on_safe_stop();
          if (order.verb == OperatorVerb::kPause) desk_->tell("note the print waits before layer 2, pass 1");
          if (order.verb == OperatorVerb::kContinue) desk_->tell("note the print goes on");
        });
      }
    });
  }
  ~LoneDesk() {
    over_ = true;
    thread_.join();
  }

  std::vector<std::string> orders() {
    const std::lock_guard lock(mutex_);
    return orders_;
  }

 private:
  std::optional<OperatorDesk> desk_;
  std::atomic<bool> over_ = false;
  std::mutex mutex_;
  std::vector<std::string> orders_;
  std::thread thread_;
};

}  // namespace firn::test
