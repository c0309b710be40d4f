// OperatorClient sends the operator's orders to a print that runs in another process.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "print/operator/operator_order.h"

namespace firn {

class OperatorClient {
 public:
  /// @throws UsageError: no run folder, a run that nobody prints now, a print of another user
  explicit OperatorClient(const std::filesystem::path& run);
  ~OperatorClient();
  OperatorClient(const OperatorClient&) = delete;
  OperatorClient& operator=(const OperatorClient&) = delete;

  /// Returns true if a print of this folder takes orders.
  static bool answers(const std::filesystem::path& run);

  /// Sends a line of the protocol (operator_desk.h). @throws std::runtime_error: the print is gone
  void say(const std::string& line);
  void send(const OperatorOrder& order);
  /// Returns the next line; nothing within `seconds`, or after the end.
  std::optional<std::string> next(double seconds);
  bool closed() const { return closed_; }
  int fd() const { return fd_; }

 private:
  int fd_ = -1;
  bool closed_ = false;
  std::string buffer_;
};

}  // namespace firn
