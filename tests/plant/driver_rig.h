// DriverRig holds drivers and twins, wired byte for byte: the common part of the rigs of both labs. Include
// after Catch.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/link/driver.h"
#include "plant/world/world.h"
#include "tests/plant/bench_lines.h"

namespace firn::plant {

class DriverRig {
 public:
  using Step = std::function<void(drivers::Driver&, drivers::Effects&)>;
  void call(std::string_view port, const Step& f) {
    drivers::Effects fx;
    Part& part = parts_.at(port);
    f(*part.driver, fx);
    part.wake_us = fx.wake_us;
    for (auto& e : fx.events) {
      if (auto* r = std::get_if<drivers::Result>(&e)) results[std::string(port)].push_back(*r);
      if (auto* x = std::get_if<drivers::Fault>(&e)) faults.push_back(std::string(port) + ": " + x->text);
      events.push_back(std::move(e));
    }
    if (!fx.tx.empty()) world.receive(port, fx.tx, now_us);
    if (!fx.reopen) return;
    world.disconnect(port, now_us);
    world.connect(port, now_us);
    call(port, [&](drivers::Driver& driver, drivers::Effects& again) { driver.closed(now_us, again); });
    call(port, [&](drivers::Driver& driver, drivers::Effects& again) { driver.opened(now_us, again); });
  }

  /// Steps until `done` or for as long as the rig allows.
  bool until(const std::function<bool()>& done) { return until(done, limit_us_); }
  bool until(const std::function<bool()>& done, std::int64_t limit_us) {
    const std::int64_t end_us = now_us + limit_us;
    while (!done() && now_us < end_us) {
      std::int64_t next_us = std::min(world.next_event_us(), end_us);
      for (const auto& [port, part] : parts_)
        if (part.wake_us != 0) next_us = std::min(next_us, std::max(part.wake_us, now_us));
      now_us = std::max(now_us, next_us);
      std::vector<std::pair<std::string_view, std::vector<std::byte>>> due;
      world.advance(now_us, [&](const World::Sent& s) {
        if (!s.close) return due.push_back({s.port, {s.bytes.begin(), s.bytes.end()}});
        gone.push_back(std::string(s.port));
      });
      for (const auto& [port, bytes] : due)
        call(port,
             [&](drivers::Driver& driver, drivers::Effects& fx) { driver.received(bytes, now_us, fx); });
      for (auto& [port, part] : parts_)
        if (part.wake_us != 0 && part.wake_us <= now_us) {
          part.wake_us = 0;
          call(port, [&](drivers::Driver& driver, drivers::Effects& fx) { driver.woke(now_us, fx); });
        }
    }
    return done();
  }

  bool all_safe() const {
    return std::ranges::all_of(parts_,
                               [](const auto& p) { return p.second.driver->state() == DeviceState::kSafe; });
  }

  /// Runs a command and returns its result.
  drivers::Result command(std::string_view port, const Step& f) {
    auto& list = results[std::string(port)];
    const std::size_t before = list.size();
    call(port, f);
    REQUIRE(until([&] { return list.size() > before; }));
    return list.back();
  }

  /// Events of one kind, of all drivers.
  template <class E>
  std::vector<E> all() const {
    std::vector<E> out;
    for (const drivers::DriverEvent& e : events)
      if (const E* p = drivers::event_cast<E>(e)) out.push_back(*p);
    return out;
  }

  MemoryRecord record;
  World world;
  std::int64_t now_us = 0;
  std::map<std::string, std::vector<drivers::Result>> results;
  std::vector<drivers::DriverEvent> events;
  std::vector<std::string> faults, gone;  ///< gone: ports that an instrument has closed

 protected:
  DriverRig(const WorldConfig& config, std::int64_t limit_us) : world(config, &record), limit_us_(limit_us) {}
  void connect(std::initializer_list<std::pair<std::string_view, drivers::Driver*>> all) {
    for (const auto& [port, driver] : all) parts_[port] = {driver, 0};
    for (auto& [port, part] : parts_) {
      world.connect(port, now_us);
      call(port, [&](drivers::Driver& driver, drivers::Effects& fx) { driver.opened(now_us, fx); });
    }
  }

 private:
  struct Part {
    drivers::Driver* driver;
    std::int64_t wake_us;
  };
  std::map<std::string_view, Part> parts_;
  std::int64_t limit_us_;
};

}  // namespace firn::plant
