// LaunchSignals keeps Ctrl-C and its like from a launcher while it runs a print: they set a flag.
#pragma once

#include <signal.h>

#include <cstddef>

namespace firn {

/// While this lives, Ctrl-C, SIGTERM and the end of the terminal are counted. Ctrl-Z and a closed pipe are
/// ignored, by the processes that are started too: a lab that stands still under a lit lamp is neither safe
/// nor printing.
class LaunchSignals {
 public:
  LaunchSignals();
  ~LaunchSignals();
  LaunchSignals(const LaunchSignals&) = delete;
  LaunchSignals& operator=(const LaunchSignals&) = delete;

  /// Returns how often the print was interrupted.
  int interrupted() const;

 private:
  static constexpr int kHandled[] = {SIGINT, SIGTERM, SIGHUP, SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE};
  struct sigaction before_[sizeof kHandled / sizeof *kHandled] = {};
};

}  // namespace firn
