// A lane joins a further connection of ssh to the `firn host` that serves a print: a socket of this computer
// that only its own user may use.
#pragma once

#include <string>

struct pollfd;

namespace firn {

/// Waits for lanes at a socket without a place in the file system.
class LaneDoor {
 public:
  /// @throws std::runtime_error naming the system's reason
  LaneDoor();
  ~LaneDoor();
  LaneDoor(const LaneDoor&) = delete;
  LaneDoor& operator=(const LaneDoor&) = delete;

  const std::string& name() const { return name_; }
  int fd() const { return fd_; }
  /// Returns the next lane; -1: none waits. One of another user is closed.
  int accept();

 private:
  std::string name_;
  int fd_ = -1;
};

/// Carries bytes between standard input and output and the door `name`, until one of them ends.
/// @throws std::runtime_error: there is no such door
void carry_lane(const std::string& name);

}  // namespace firn
