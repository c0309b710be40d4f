// FakeRig holds a driver wired to a fake instrument in simulated time. The line between them can lose, delay,
// cut and damage the bytes of the instrument, and ports can close.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/link/driver.h"
#include "tests/support/figure_words.h"

namespace firn::drivers::test {

/// Fake: take(bytes, now), advance(now), next_us(), out.
template <class DriverType, class Fake>
class FakeRig {
 public:
  FakeRig(DriverType& driver, Fake& fake) : driver_(driver), fake_(fake) {}

  /// Called with each thing said by the instrument: change it, empty it, or @return how much later it comes
  /// [us].
  std::function<std::int64_t(std::string&)> line = [](std::string&) { return 0; };
  std::int64_t latency_us = 500;
  bool hung = false;  ///< the instrument takes bytes and does nothing
  bool unplugged = false;
  std::int64_t now_us = 1'000'000;
  std::vector<DriverEvent> events;
  std::int64_t bytes_sent = 0;

  void open() {
    connected_ = true;
    step([&](Effects& fx) { driver_.opened(now_us, fx); });
  }
  void close() {
    connected_ = false;
    replies_.clear();
    step([&](Effects& fx) { driver_.closed(now_us, fx); });
  }
  template <class F>
  void act(F&& f) {
    step([&](Effects& fx) { f(now_us, fx); });
  }
  /// Runs until `done` or `limit_s` have passed. @returns done()
  template <class Done>
  bool run(Done&& done, double limit_s) {
    const std::int64_t end = now_us + std::int64_t(limit_s * 1e6);
    for (int n = 0; !done(); ++n) {
      if (n > 2'000'000) throw std::logic_error("no end");
      std::int64_t next = end;
      if (!replies_.empty()) next = std::min(next, replies_.front().t_us);
      if (wake_us_ != 0) next = std::min(next, wake_us_);
      if (!hung) next = std::min(next, fake_.next_us());
      now_us = std::max(now_us, next);
      if (!hung) {
        fake_.advance(now_us);
        hear();
      }
      if (!replies_.empty() && replies_.front().t_us <= now_us) {
        const std::string bytes = replies_.front().bytes;
        replies_.pop_front();
        step([&](Effects& fx) {
          driver_.received(std::as_bytes(std::span(bytes.data(), bytes.size())), now_us, fx);
        });
      } else if (wake_us_ != 0 && wake_us_ <= now_us) {
        step([&](Effects& fx) { driver_.woke(now_us, fx); });
      }
      if (now_us >= end) return done();
    }
    return true;
  }
  /// Until the driver says something of its own accord, and so much longer.
  bool run_past_next_request(double limit_s, std::int64_t further_us) {
    const std::int64_t before = bytes_sent;
    if (!run([&] { return bytes_sent != before; }, limit_s)) return false;
    run_for(double(further_us) * 1e-6);
    return true;
  }
  void run_for(double s) {
    run([] { return false; }, s);
  }
  template <class E>
  std::vector<E> all() const {
    std::vector<E> found;
    for (const DriverEvent& e : events)
      if (const E* p = event_cast<E>(e)) found.push_back(*p);
    return found;
  }
  bool faulted(std::int32_t code) const {
    const auto faults = all<Fault>();
    return std::any_of(faults.begin(), faults.end(), [&](const Fault& f) { return f.code == code; });
  }

 private:
  struct Said {
    std::int64_t t_us;
    std::string bytes;
  };

  template <class F>
  void step(F&& f) {
    fx_.clear();
    f(fx_);
    bytes_sent += std::int64_t(fx_.tx.size());
    const std::string sent(reinterpret_cast<const char*>(fx_.tx.data()), fx_.tx.size());
    for (DriverEvent& e : fx_.events) {
      const Fault* fault = event_cast<Fault>(e);
      const std::string wrong =
          fault ? figure_words::figure_contradiction(fault->text, fault->figure) : std::string();
      if (!wrong.empty()) throw std::runtime_error("a fault's figure: " + wrong);
      events.push_back(std::move(e));
    }
    wake_us_ = fx_.wake_us;
    if (fx_.reopen && !unplugged) return open();
    if (!connected_ || hung || sent.empty()) return;
    fake_.take(sent, now_us);
    hear();
  }
  // Everything said so far goes on the line, one thing (up to a line's end) at a time.
  void hear() {
    std::string said = std::exchange(fake_.out, {});
    if (!connected_) return;
    for (std::size_t at = 0; at < said.size();) {
      const std::size_t end = lines ? std::min(said.find('\n', at), said.size() - 1) + 1 : said.size();
      std::string one = said.substr(at, end - at);
      at = end;
      const std::int64_t later = line(one);
      std::int64_t t = now_us + latency_us + later;
      if (!replies_.empty()) t = std::max(t, replies_.back().t_us);
      for (std::size_t n = 0; n < one.size(); n += split ? split : one.size())
        replies_.push_back({t, one.substr(n, split ? split : one.size())});
    }
  }

  DriverType& driver_;
  Fake& fake_;
  Effects fx_;
  std::deque<Said> replies_;
  std::int64_t wake_us_ = 0;
  bool connected_ = false;

 public:
  bool lines = true;      ///< the instrument's lines end with LF
  std::size_t split = 0;  ///< 0 = whole, else pieces of this size
};

}  // namespace firn::drivers::test
