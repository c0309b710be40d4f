// Watchdog raises an exception in threads that run Python code longer than allowed.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>

namespace firn::python {

class Watchdog {
 public:
  /// Holds the watch of one call.
  struct Watch {
    unsigned long thread = 0;
    std::chrono::steady_clock::time_point until;
    bool fired = false;
  };
  using Token = std::list<Watch>::iterator;

  /// @param error the class of the exception, a BaseException. The watchdog lives as long as the process.
  explicit Watchdog(pybind11::object error);

  /// Watches this thread. @pre it holds the interpreter
  Token arm(double longest_s);
  /// Ends the watch and takes back an exception that has not been raised yet. @pre as for arm
  /// @returns true if the time was over
  bool disarm(Token watch);

 private:
  [[noreturn]] void watch();

  pybind11::object error_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Watch> watches_;
};

}  // namespace firn::python
