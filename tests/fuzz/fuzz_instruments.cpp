// Any bytes from an instrument, in any split: no driver crashes, hangs or writes without end.
#include "drivers/camera/camera.h"
#include "drivers/gas/gas.h"
#include "drivers/heater/heater.h"
#include "drivers/jet/jet.h"
#include "drivers/jet/microdrop.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/robot/robot.h"
#include "drivers/stage/stage.h"
#include "drivers/valve/valve.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;
using namespace firn::drivers;

namespace {

void no_command(int, std::int64_t, Effects&) {}

struct Order {
  const char* verb;
  std::vector<double> values;
};
const std::vector<Order> kOrders{{"reset", {}},
                                 {"serial", {}},
                                 {"fire", {3}},
                                 {"continuous", {2}},
                                 {"waveform", {20, -20, 20, 40}},
                                 {"jog", {1, 1, 1, 5, 0}},
                                 {"jog", {1, 2, 0}},
                                 {"where", {}},
                                 {"params", {}},
                                 {"pulse", {3, 1}},
                                 {"shutter", {0.5}},
                                 {"hours", {}},
                                 {"read", {}},
                                 {"errors", {}},
                                 {"lines", {5}},
                                 {"spit", {5}}};

// A pause of 250 .. 254 is a command: number, without bytes; 230 .. 245 an order of a person.
template <class Command = void (*)(int, std::int64_t, Effects&)>
void play(Driver& driver, const std::uint8_t* data, std::size_t size, Command&& command = no_command) {
  Effects fx;
  std::int64_t now_us = 1000;
  std::size_t written = 0, steps = 0;
  const auto done = [&] {
    written += fx.tx.size();
    fx.clear();
  };
  driver.opened(now_us, fx);
  done();
  // Input: {bytes at once, pause in units of 20 ms, bytes…}.
  for (std::size_t at = 0; at + 2 <= size; ++steps) {
    const std::size_t n = std::min<std::size_t>(data[at], size - at - 2);
    now_us += std::int64_t(data[at + 1]) * 20'000;
    driver.woke(now_us, fx);
    done();
    driver.received(as_bytes(data + at + 2, n), now_us, fx);
    done();
    if (data[at + 1] >= 230 && data[at + 1] < 230 + kOrders.size()) {
      const Order& order = kOrders[data[at + 1] - 230u];
      driver.serve(order.verb, order.values, now_us, fx);
      done();
    }
    if (data[at + 1] >= 250 && data[at + 1] < 255) {
      command(data[at + 1] - 250, now_us, fx);
      done();
    }
    if (data[at + 1] == 255) {
      driver.safe_stop(now_us, fx);
      done();
    }
    at += 2 + n;
  }
  require(written <= 4096 * (steps + 2), "what is written stays in proportion to what happens");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  switch (data[0] % 11) {
    case 0: {
      Stage stage{StageOptions{}};
      play(stage, data + 1, size - 1);
      break;
    }
    case 1: {
      Jet jet{JetOptions{}};
      play(jet, data + 1, size - 1);
      break;
    }
    case 2: {
      LaserProfiler profiler{LaserProfilerOptions{}};
      play(profiler, data + 1, size - 1);
      break;
    }
    case 3: {
      Lamp lamp{LampOptions{}};
      play(lamp, data + 1, size - 1);
      break;
    }
    case 4: {
      Robot robot{RobotOptions{}};
      play(robot, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        static const std::vector<double> path{0.1,  0.2, 20.0, 0.0,  0.11, 0.21,
                                              20.0, 0.0, 0.12, 0.22, 20.0, 0.0};
        if (n == 0) robot.home(now_us, fx);
        if (n == 1) robot.add_path(1, 0.016, 4, path, now_us, fx);
        if (n == 2) robot.run({1, 0, 0}, kSignalValveA, now_us, fx);
        if (n == 3) robot.move_to({0.3, 0.3, 100.0, 0.0}, 0, now_us, fx);
      });
      break;
    }
    case 5: {
      Valve valve{ValveOptions{}};
      play(valve, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        static const std::vector<std::int32_t> list{0, 4, 8};
        if (n == 0) valve.add_list({1, 0}, 0.002, 0.00125, list, now_us, fx);
        if (n == 1) valve.load({1, 0}, now_us, fx);
        if (n == 2) valve.arm({1, 0}, now_us, fx);
        if (n == 3) valve.disarm(now_us, fx);
      });
      break;
    }
    case 6: {
      LaserPoint laser{LaserPointOptions{}};
      play(laser, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        if (n == 0) laser.arm(0, 100, 0.01, now_us, fx);
        if (n == 1) laser.collect(now_us, fx);
        if (n == 2) laser.reading(now_us, fx);
      });
      break;
    }
    case 8: {
      Camera camera{CameraOptions{}};
      play(camera, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        if (n == 0) camera.sweep({3, 40.0, 10.0}, now_us, fx);
        if (n == 1) camera.set_up({1, 5.0}, now_us, fx);
      });
      break;
    }
    case 9: {
      Gas gas{GasOptions{}};
      play(gas, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        if (n == 0) gas.set(20.0, 40.0, now_us, fx);
        if (n == 1) gas.set(0.0, 0.0, now_us, fx);
      });
      break;
    }
    case 10: {
      Microdrop jet{JetOptions{}};
      play(jet, data + 1, size - 1);
      break;
    }
    default: {
      Heater heater{HeaterOptions{}};
      play(heater, data + 1, size - 1, [&](int n, std::int64_t now_us, Effects& fx) {
        if (n == 0) heater.set({20, 22, 20}, now_us, fx);
      });
    }
  }
  return 0;
}
