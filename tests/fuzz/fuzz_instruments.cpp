// Any bytes from an instrument, in any split: no driver crashes, hangs or writes without end.
#include "drivers/jet/jet.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/stage/stage.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;
using namespace firn::drivers;

namespace {

void play(Driver& driver, const std::uint8_t* data, std::size_t size) {
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
    if (data[at + 1] == 255) driver.safe_stop(now_us, fx), done();
    at += 2 + n;
  }
  require(written <= 4096 * (steps + 2), "what is written stays in proportion to what happens");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  switch (data[0] % 4) {
    case 0: {
      Stage stage{StageConfig{}};
      play(stage, data + 1, size - 1);
      break;
    }
    case 1: {
      Jet jet{JetConfig{}};
      play(jet, data + 1, size - 1);
      break;
    }
    case 2: {
      LaserProfiler profiler{LaserProfilerConfig{}};
      play(profiler, data + 1, size - 1);
      break;
    }
    default: {
      Lamp lamp{LampConfig{}};
      play(lamp, data + 1, size - 1);
    }
  }
  return 0;
}
