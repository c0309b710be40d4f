// The five drivers of the path printer wired to the simulated world at byte level, in simulated time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drivers/heater/heater.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/robot/robot.h"
#include "drivers/valve/valve.h"
#include "plant/ice/ice_lab.h"
#include "plant/world.h"

namespace firn::drivers::test {

class IceRig {
 public:
  explicit IceRig(const plant::IceWorldConfig& ice = plant::IceWorldConfig{}, std::uint64_t seed = 1);

  using Act = std::function<void(std::int64_t, Effects&)>;
  void act(std::string_view port, const Act& f);
  bool run(const std::function<bool()>& done, double limit_s);
  void run_for(double s) {
    run([] { return false; }, s);
  }
  void start();  ///< connects everything, waits until all are SAFE, homes the robot
  Result command(std::string_view port, const Act& f, double limit_s = 300);
  void kill(std::string_view port);
  void resume(std::string_view port);
  void fault(std::string_view port, plant::FaultKind kind, std::int64_t count = 1, std::int64_t delay_us = 0);

  template <class E>
  std::vector<E> all(std::string_view port) const {
    std::vector<E> out;
    const auto at = events.find(port);
    if (at == events.end()) return out;
    for (const DriverEvent& e : at->second)
      if (const E* p = std::get_if<E>(&e)) out.push_back(*p);
    return out;
  }
  Driver& driver(std::string_view name) { return *port(name).driver; }

  plant::World world;
  Robot robot;
  Valve valve_a, valve_b;
  LaserPoint laser;
  Heater heater;
  std::int64_t now_us = 0;
  std::map<std::string, std::vector<DriverEvent>, std::less<>> events;

 private:
  struct Port {
    std::string name;
    Driver* driver;
    std::int64_t wake_us = 0;
    bool connected = false;
    bool dead = false;
  };
  Port& port(std::string_view name);
  void step(Port& p, const std::function<void(Effects&)>& f);

  std::vector<Port> ports_;
};

}  // namespace firn::drivers::test
