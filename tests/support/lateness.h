// Lateness measures how late this computer lets a thread run while it lives: what a test of a time may add to
// that time on a loaded computer.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace firn::test {

class Lateness {
 public:
  Lateness()
      : thread_([this] {
          using Clock = std::chrono::steady_clock;
          constexpr std::chrono::milliseconds kStep{1};
          while (!over_) {
            const auto due = Clock::now() + kStep;
            std::this_thread::sleep_until(due);
            const std::chrono::duration<double> late = Clock::now() - due;
            longest_s_ = std::max(longest_s_.load(), late.count());
          }
        }) {}
  ~Lateness() {
    over_ = true;
    thread_.join();
  }
  Lateness(const Lateness&) = delete;
  Lateness& operator=(const Lateness&) = delete;

  double longest_s() const { return longest_s_; }

 private:
  std::atomic<bool> over_ = false;
  std::atomic<double> longest_s_ = 0.0;
  std::thread thread_;
};

}  // namespace firn::test
