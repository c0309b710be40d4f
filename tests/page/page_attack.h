// PageAttack besets a page from a thread of its own: connections that say nothing, garbage, random frames,
// tabs that follow maps and never read.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

namespace firn::test {

class PageAttack {
 public:
  struct Size {
    int connections = 200;
    int frames = 2'000;  ///< random ones over open WebSockets
    int deaf = 8;        ///< tabs that never read
  };
  PageAttack(std::string address, Size size, std::uint64_t seed);
  ~PageAttack();  ///< ends the attack and its connections
  PageAttack(const PageAttack&) = delete;
  PageAttack& operator=(const PageAttack&) = delete;

  /// Waits until so many frames were sent, at most all; the connections stay.
  void wait(std::int64_t frames) const;
  std::int64_t frames_sent() const { return frames_; }

 private:
  void run(Size size, std::uint64_t seed);

  std::string address_;
  std::atomic<bool> over_ = false, stop_ = false;
  std::atomic<std::int64_t> frames_ = 0;
  std::thread thread_;
};

}  // namespace firn::test
