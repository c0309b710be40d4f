// Ssh is a running ssh: a byte stream to a program on another computer, and ssh's words when it fails.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

struct pollfd;

namespace firn::relay {

inline constexpr int kSshFailed = 255;  ///< exit code of ssh where the connection failed

class Ssh {
 public:
  /// Starts `ssh ADDRESS COMMAND`, by the user's keys and configuration, never asking for a password.
  /// @throws std::runtime_error: ssh cannot be started
  Ssh(const std::string& address, const std::string& command);
  /// Ends ssh, and with it the connection.
  ~Ssh();
  Ssh(const Ssh&) = delete;
  Ssh& operator=(const Ssh&) = delete;

  /// Its standard input and output; the caller closes it.
  int take_stream();
  void add_to(std::vector<pollfd>& fds) const;
  /// Copies the messages of ssh and of the other computer to this process's stderr.
  void service();
  bool running();
  /// Returns why the connection failed, from the last line that was said, and the remedy.
  std::string trouble() const;

 private:
  std::string address_, command_, said_;
  pid_t pid_ = -1;
  int stream_ = -1, errors_ = -1;
  std::optional<int> status_;
};

/// Returns the trouble that a line of ssh means, and the remedy: "is not known to ssh by this key: …".
std::string ssh_trouble(const std::string& last_line, const std::string& address, const std::string& command);

}  // namespace firn::relay
