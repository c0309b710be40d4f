#include "tests/drivers/port_rig.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <utility>

namespace firn::drivers::test {
namespace {

constexpr int kMaxWakes = 100'000;

}  // namespace

PortRig::Port& PortRig::port(std::string_view name) {
  return *std::find_if(ports_.begin(), ports_.end(), [&](const Port& p) { return p.name == name; });
}

void PortRig::step(Port& p, const std::function<void(Effects&)>& f) {
  Effects fx;
  f(fx);
  p.wake_us = fx.wake_us;
  for (DriverEvent& e : fx.events) events[p.name].push_back(std::move(e));
  if (!fx.tx.empty()) {
    const std::string sent(reinterpret_cast<const char*>(fx.tx.data()), fx.tx.size());
    written[p.name] += sent;
    if (p.connected) {
      const std::string come = to_instrument(p.name, sent);
      world.receive(p.name, std::as_bytes(std::span(come.data(), come.size())), now_us);
    }
  }
  if (!fx.reopen) return;
  if (std::exchange(p.connected, false)) {  // told of a port that was open, as live
    world.disconnect(p.name, now_us);
    step(p, [&](Effects& again) { p.driver->closed(now_us, again); });
    if (p.connected) return;
  }
  if (!open_line(p.name)) return;  // the driver asks again
  p.connected = true;
  world.connect(p.name, now_us);
  step(p, [&](Effects& again) { p.driver->opened(now_us, again); });
}

void PortRig::unplug(std::string_view name) {
  Port& p = port(name);
  if (!std::exchange(p.connected, false)) return;
  close_line(name);
  world.disconnect(name, now_us);
  step(p, [&](Effects& fx) { p.driver->closed(now_us, fx); });
}

void PortRig::act(std::string_view name, const Act& f) {
  step(port(name), [&](Effects& fx) { f(now_us, fx); });
}

bool PortRig::run(const std::function<bool()>& done, double limit_s) {
  const std::int64_t end = now_us + std::int64_t(limit_s * 1e6);
  int wakes_now = 0;  // at one time
  while (!done()) {
    std::int64_t next = world.next_event_us();
    Port* due = nullptr;
    for (Port& p : ports_)
      if (!p.dead && p.wake_us != 0 && p.wake_us < next) {
        next = p.wake_us;
        due = &p;
      }
    if (next > end) {
      now_us = end;
      return done();
    }
    wakes_now = next > now_us ? 0 : wakes_now + 1;
    if (due && wakes_now > kMaxWakes)
      throw std::logic_error(due->name + ", " + name(due->driver->state()) + ", wakes for nothing at " +
                             std::to_string(now_us) + " us");
    now_us = std::max(now_us, next);
    if (due) {
      step(*due, [&](Effects& fx) { due->driver->woke(now_us, fx); });
      continue;
    }
    struct Arrived {
      std::string port, bytes;
      bool close;
    };
    std::vector<Arrived> arrived;
    world.advance(now_us, [&](const plant::World::Sent& s) {
      arrived.push_back(
          {std::string(s.port), {reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size()}, s.close});
    });
    for (const Arrived& a : arrived) {
      Port& p = port(a.port);
      if (p.dead) continue;
      if (a.close) close_line(a.port);
      if (a.close) p.connected = false;
      const std::string bytes = a.close ? std::string() : to_host(a.port, a.bytes);
      step(p, [&](Effects& fx) {
        if (a.close)
          p.driver->closed(now_us, fx);
        else
          p.driver->received(std::as_bytes(std::span(bytes.data(), bytes.size())), now_us, fx);
      });
    }
  }
  return true;
}

bool PortRig::all_safe() const {
  return std::all_of(ports_.begin(), ports_.end(), [](const Port& p) { return p.driver->safe(); });
}

void PortRig::connect_all() {
  for (Port& p : ports_) {
    REQUIRE(open_line(p.name));
    world.connect(p.name, now_us);
    p.connected = true;
    step(p, [&](Effects& fx) { p.driver->opened(now_us, fx); });
  }
  REQUIRE(run([&] { return all_safe(); }, 60.0));
}

void PortRig::kill(std::string_view name) {
  Port& p = port(name);
  if (p.connected) world.disconnect(name, now_us);
  p.connected = false;
  p.dead = true;
}

void PortRig::resume(std::string_view name) {
  Port& p = port(name);
  p.dead = false;
  step(p, [&](Effects& fx) { p.driver->closed(now_us, fx); });
  world.connect(name, now_us);
  p.connected = true;
  step(p, [&](Effects& fx) { p.driver->opened(now_us, fx); });
}

}  // namespace firn::drivers::test
