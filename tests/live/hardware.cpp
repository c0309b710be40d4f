#include "tests/live/hardware.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "runtime/run_clock.h"

extern char** environ;

namespace firn::test {

namespace fs = std::filesystem;

Hardware::Hardware(const Experiment& e) {
  std::ofstream(folder_.path() / "experiment.toml") << dump(e);
  start();
  const fs::path io = folder_.path() / "io";
  stage_ = std::make_unique<PortBridge>(PortBridge::Kind::kTcp, io / "stage");
  profiler_ = std::make_unique<PortBridge>(PortBridge::Kind::kTcp, io / "laser_profiler");
  jet_ = std::make_unique<PortBridge>(PortBridge::Kind::kSerial, io / "jet");
  lamp_ = std::make_unique<PortBridge>(PortBridge::Kind::kSerial, io / "lamp");
}

void Hardware::start() {
  const std::string program = FIRN_BINARY_DIR "/bin/world";
  const std::string run = folder_.path().string(), epoch = std::to_string(monotonic_ns());
  const char* argv[] = {program.c_str(), "--run", run.c_str(), "--epoch-ns", epoch.c_str(), nullptr};
  if (::posix_spawn(&pid_, program.c_str(), nullptr, nullptr, const_cast<char**>(argv), environ) != 0)
    throw std::runtime_error(program + " cannot be started");
  for (int n = 0; n < 2000 && !fs::exists(folder_.path() / "io" / "lamp"); ++n) ::usleep(5000);
}

void Hardware::stop() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGTERM);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void Hardware::connect(Experiment& e, bool lamp) const {
  e.run.time_scale = 1.0;
  e.devices.stage = stage_->address();
  e.devices.laser_profiler = profiler_->address();
  e.devices.jet = jet_->address(9600);
  if (lamp) e.devices.lamp = lamp_->address(19200);
}

}  // namespace firn::test
