// ScriptBench drives a driver class in Python in simulated time, with this test as its program: it answers
// the driver's calls and sees the bytes that reach the instrument.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/link/driver.h"

namespace firn::drivers::test {

class ScriptBench {
 public:
  explicit ScriptBench(Driver& driver) : driver_(driver) {}

  std::int64_t now_us = 1'000'000;
  std::string line;                ///< bytes for the instrument
  std::vector<std::string> calls;  ///< lines for the program, without their ends
  std::vector<DriverEvent> events;
  int reopens = 0, line_reopens = 0;

  void open_program() {
    step([&](Effects& fx) { driver_.opened(now_us, fx); });
  }
  void close_program() {
    step([&](Effects& fx) { driver_.closed(now_us, fx); });
  }
  void open_line() {
    step([&](Effects& fx) { driver_.line_opened(now_us, fx); });
  }
  void close_line() {
    step([&](Effects& fx) { driver_.line_closed(now_us, fx); });
  }
  void hear(std::string_view bytes) {
    step([&](Effects& fx) { driver_.line_received(std::as_bytes(std::span(bytes)), now_us, fx); });
  }
  void safe_stop() {
    step([&](Effects& fx) { driver_.safe_stop(now_us, fx); });
  }
  template <class Act>
  void command(Act act) {
    step([&](Effects& fx) { act(now_us, fx); });
  }
  /// The program says a line.
  void say(const std::string& text) {
    const std::string whole = text + "\n";
    step([&](Effects& fx) { driver_.received(std::as_bytes(std::span(whole)), now_us, fx); });
  }
  /// Returns the newest line for the program without its number and time: "call on iris_percent=80".
  std::string newest() const {
    if (calls.empty()) return {};
    std::string text = calls.back();
    for (int words = text.starts_with("begin ") ? 1 : 2; words > 0; --words) {
      const std::size_t first = text.find(' ');
      if (first == text.npos) break;
      text.erase(first, std::min(text.find(' ', first + 1), text.size()) - first);
    }
    return text;
  }
  std::string number() const {
    const std::string& text = calls.back();
    const std::size_t first = text.find(' ');
    return text.substr(first + 1, text.find(' ', first + 1) - first - 1);
  }
  /// Answers the newest call.
  void done(const std::string& answer = ":") { say("done " + number() + " " + answer); }
  void fail(const std::string& why) { say("fail " + number() + " " + why); }
  void advance_us(std::int64_t by) {
    const std::int64_t until = now_us + by;
    while (wake_us_ != 0 && wake_us_ <= until) {
      now_us = std::max(now_us, wake_us_);
      wake_us_ = 0;
      step([&](Effects& fx) { driver_.woke(now_us, fx); });
    }
    now_us = until;
  }
  /// Starts the program with these declarations, up to an instrument that is safe.
  void become_safe(const std::string& declared = "timeout_s=1 safe_bytes=79,70,70,10") {
    open_line();
    open_program();
    done(": " + declared);
    done();                // connect
    done(":SCPI%20lamp");  // identify
    done();                // safe
    const bool asks = calls.back().starts_with("call ");
    calls.erase(calls.begin(), calls.end() - (asks ? 1 : 0));  // its next question is to be answered
    line.clear();
  }

  template <class E>
  std::vector<E> all() const {
    std::vector<E> out;
    for (const DriverEvent& e : events)
      if (const E* p = event_cast<E>(e)) out.push_back(*p);
    return out;
  }

 private:
  template <class Act>
  void step(Act act) {
    fx_.clear();
    act(fx_);
    for (const std::byte b : fx_.line_tx) line += char(b);
    std::string said;
    for (const std::byte b : fx_.tx) said += char(b);
    for (std::size_t end; (end = said.find('\n')) != said.npos; said.erase(0, end + 1))
      calls.push_back(said.substr(0, end));
    events.insert(events.end(), fx_.events.begin(), fx_.events.end());
    reopens += fx_.reopen;
    line_reopens += fx_.reopen_line;
    wake_us_ = fx_.wake_us;
  }

  Driver& driver_;
  Effects fx_;
  std::int64_t wake_us_ = 0;
};

}  // namespace firn::drivers::test
