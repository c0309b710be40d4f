// Bench drives one driver in tests: it holds simulated time, the bytes both ways and the recorded events, and
// plays transcripts against the driver.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/link/driver.h"

namespace firn::drivers::test {

class Bench {
 public:
  explicit Bench(Driver& driver) : driver_(driver) {}

  std::int64_t now_us = 1'000'000;
  std::string tx;  ///< sent and not yet taken
  std::vector<DriverEvent> events;
  int reopens = 0;
  std::size_t split = 0;  ///< 0 = bytes arrive whole, else in pieces of this size

  void open() {
    step([&](Effects& fx) { driver_.opened(now_us, fx); });
  }
  void close() {
    step([&](Effects& fx) { driver_.closed(now_us, fx); });
  }
  void safe_stop() {
    step([&](Effects& fx) { driver_.safe_stop(now_us, fx); });
  }
  void command(const std::function<void(std::int64_t, Effects&)>& f) {
    step([&](Effects& fx) { f(now_us, fx); });
  }
  void feed(std::string_view bytes);
  void advance_us(std::int64_t by);  ///< fires every wake on the way
  bool advance_to_wake();            ///< false when no wake is armed
  std::int64_t wake_us() const { return wake_us_; }
  std::string take() { return std::exchange(tx, {}); }
  std::string take_line();  ///< up to and including "\n" or "\r"; empty if there is none

  template <class E>
  std::vector<E> all() const {
    std::vector<E> out;
    for (const DriverEvent& e : events)
      if (const E* p = event_cast<E>(e)) out.push_back(*p);
    return out;
  }

 private:
  void step(const std::function<void(Effects&)>& f);

  Driver& driver_;
  Effects fx_;
  std::int64_t wake_us_ = 0;
};

/// Returns one line that describes the event: "state safe: homed", "result done 12/12", "fault 2 code 5: …".
std::string describe(const DriverEvent& event);

/// Plays a transcript; fails (REQUIRE) on any byte that differs, is missing or is left over.
///   # comment      hex            (from here on, bytes are written in hex)
///   = command      handed to `command`        * text   an event whose description holds the text must come
///   next > bytes        the driver must send       < bytes  the instrument answers          ~50ms  time
///   passes
/// Text lines know \n \r \\; a `>` lets time pass until the driver sends.
void play(Driver& driver, const std::string& path,
          const std::function<void(const std::string&, std::int64_t, Effects&)>& command,
          std::size_t split = 0);

std::string hex(std::string_view bytes);
std::string unhex(std::string_view text);

}  // namespace firn::drivers::test
