// PythonChild is the program that runs a driver class in Python (python/lib/firn/driver_program.py), reached
// through one end of a socket.
//
// It is ended by closing that end: it then breaks off what it does, makes an instrument safe that it holds by
// itself, and exits. Its kernel timer ends it when a method does not return; the next start kills what is
// left.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace firn {

class PythonChild {
 public:
  PythonChild() = default;
  PythonChild(PythonChild&& other) noexcept
      : pid_(std::exchange(other.pid_, -1)), kill_at_us_(other.kill_at_us_) {}
  PythonChild& operator=(PythonChild&&) = delete;
  ~PythonChild();

  /// Starts `python3` with the modules, name and file of each. @pre ended()
  /// @returns this end of the socket, nonblocking; -1 with `why`
  int start(const std::vector<std::pair<std::string, std::string>>& modules, std::string& why);
  /// The socket was closed: the program is given until then to end by itself.
  void let_go(std::int64_t wall_us);
  /// Returns whether no program runs any more. One whose time is over is killed.
  bool ended(std::int64_t wall_us);

 private:
  pid_t pid_ = -1;
  std::int64_t kill_at_us_ = INT64_MAX;
};

}  // namespace firn
