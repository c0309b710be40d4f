// OperatorClient sends the operator's orders to a print that runs in another process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "print/operator/operator_order.h"

namespace firn {

class OperatorClient {
 public:
  /// Connects, and says for which run its orders are. @throws UsageError: no run folder, a run that nobody
  /// prints now, a print of another user, a print that accepts nobody for 5 s
  explicit OperatorClient(const std::filesystem::path& run);
  /// The same without waiting. Returns nullptr: so many connect at this moment that it must be tried again.
  /// @param run_id of the run that is meant; 0: that of the folder
  static std::unique_ptr<OperatorClient> try_connect(const std::filesystem::path& run,
                                                     std::int64_t run_id = 0);
  ~OperatorClient();
  OperatorClient(const OperatorClient&) = delete;
  OperatorClient& operator=(const OperatorClient&) = delete;

  /// Returns true if a print of this folder takes orders.
  static bool answers(const std::filesystem::path& run);
  /// Returns "running", "pausing", or "paused: the print waits before layer 7, pass 2"; "running" too of a
  /// print that does not answer within 1 s.
  static std::string state_of(const std::filesystem::path& run);
  /// Sends a line of the protocol (operator_desk.h). @throws std::runtime_error: the print is gone, or takes
  /// nothing for 5 s
  void say(const std::string& line);
  void send(const OperatorOrder& order);
  /// Returns the next line; nothing within `seconds`, or after the end.
  std::optional<std::string> next(double seconds);
  /// Waits for the end of the process that prints: the run is sealed, packed and free for others then.
  /// @param note gets a sentence if that takes over 2 s
  /// @returns false if `interrupted` came first
  bool await_end(const std::function<bool()>& interrupted,
                 const std::function<void(const std::string&)>& note) const;
  bool closed() const { return closed_; }
  int fd() const { return fd_; }

 private:
  explicit OperatorClient(int fd) : fd_(fd) {}
  int fd_ = -1;
  bool closed_ = false;
  std::string buffer_;
};

}  // namespace firn
