#include "tests/drivers/ice_rig.h"

#include <algorithm>
#include <catch2/catch.hpp>

namespace firn::drivers::test {
namespace {

plant::WorldConfig world_config(const plant::IceWorldConfig& ice, std::uint64_t seed) {
  plant::WorldConfig c;
  c.kind = "ice";
  c.seed = seed;
  c.ice = ice;
  return c;
}

ValveConfig valve_config(int valve) {
  ValveConfig c;
  c.valve = valve;
  return c;
}

LaserPointConfig laser_config() {
  LaserPointConfig c;
  c.sampling_us = 200;
  c.averaging = 2;
  return c;
}

}  // namespace

IceRig::IceRig(const plant::IceWorldConfig& ice, std::uint64_t seed)
    : world(world_config(ice, seed), nullptr),
      robot(RobotConfig{}),
      valve_a(valve_config(1)),
      valve_b(valve_config(2)),
      laser(laser_config()),
      heater(HeaterConfig{}) {
  ports_ = {{"robot", &robot}, {"valve_a", &valve_a}, {"valve_b", &valve_b}, {"laser_point", &laser}, {"heater", &heater}};
}

IceRig::Port& IceRig::port(std::string_view name) {
  return *std::find_if(ports_.begin(), ports_.end(), [&](const Port& p) { return p.name == name; });
}

void IceRig::step(Port& p, const std::function<void(Effects&)>& f) {
  Effects fx;
  f(fx);
  p.wake_us = fx.wake_us;
  for (DriverEvent& e : fx.events) events[p.name].push_back(std::move(e));
  if (!fx.tx.empty() && p.connected) world.receive(p.name, fx.tx, now_us);
  if (!fx.reopen) return;
  if (p.connected) world.disconnect(p.name, now_us);
  p.connected = true;
  world.connect(p.name, now_us);
  step(p, [&](Effects& again) { p.driver->opened(now_us, again); });
}

void IceRig::act(std::string_view name, const Act& f) {
  step(port(name), [&](Effects& fx) { f(now_us, fx); });
}

bool IceRig::run(const std::function<bool()>& done, double limit_s) {
  const std::int64_t end = now_us + std::int64_t(limit_s * 1e6);
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
      arrived.push_back({std::string(s.port), {reinterpret_cast<const char*>(s.bytes.data()), s.bytes.size()}, s.close});
    });
    for (const Arrived& a : arrived) {
      Port& p = port(a.port);
      if (p.dead) continue;
      if (a.close) p.connected = false;
      step(p, [&](Effects& fx) {
        if (a.close)
          p.driver->closed(now_us, fx);
        else
          p.driver->received(std::as_bytes(std::span(a.bytes.data(), a.bytes.size())), now_us, fx);
      });
    }
  }
  return true;
}

Result IceRig::command(std::string_view name, const Act& f, double limit_s) {
  act(name, f);
  REQUIRE(run([&] { return !port(name).driver->busy(); }, limit_s));
  return all<Result>(name).back();
}

void IceRig::start() {
  for (Port& p : ports_) {
    world.connect(p.name, now_us);
    p.connected = true;
    step(p, [&](Effects& fx) { p.driver->opened(now_us, fx); });
  }
  REQUIRE(run([&] { return std::all_of(ports_.begin(), ports_.end(), [](const Port& p) { return p.driver->safe(); }); }, 60.0));
  REQUIRE(command("robot", [&](std::int64_t t, Effects& fx) { robot.home(t, fx); }).outcome == Outcome::kDone);
}

void IceRig::kill(std::string_view name) {
  Port& p = port(name);
  if (p.connected) world.disconnect(name, now_us);
  p.connected = false;
  p.dead = true;
}

void IceRig::resume(std::string_view name) {
  Port& p = port(name);
  p.dead = false;
  step(p, [&](Effects& fx) { p.driver->closed(now_us, fx); });
  world.connect(name, now_us);
  p.connected = true;
  step(p, [&](Effects& fx) { p.driver->opened(now_us, fx); });
}

void IceRig::fault(std::string_view name, plant::FaultKind kind, std::int64_t count, std::int64_t delay_us) {
  plant::SimFault f;
  f.port = name;
  f.kind = kind;
  f.count = count;
  f.delay_us = delay_us;
  world.inject(f, now_us);
}

}  // namespace firn::drivers::test
