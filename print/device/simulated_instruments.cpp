#include "print/device/simulated_instruments.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

#include "config/fields.h"
#include "files/text_file.h"
#include "runtime/run_clock.h"

extern char** environ;

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kBeginWithin_ms = 10'000;

}  // namespace

SimulatedInstruments::SimulatedInstruments(const Experiment& experiment) {
  std::string name = (fs::temp_directory_path() / "firn-device-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error(name + ": cannot be made");
  folder_ = name;
  Experiment alone = experiment;
  alone.devices = {};
  write_file_atomically(folder_ / "experiment.toml", dump(alone));
  const fs::path beside = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path program = fs::exists(beside / "world") ? beside / "world" : beside / ".." / "bin" / "world";
  const std::string run = folder_.string(), epoch = std::to_string(monotonic_ns());
  const char* argv[] = {program.c_str(), "--run", run.c_str(), "--epoch-ns", epoch.c_str(), nullptr};
  if (::posix_spawn(&pid_, program.c_str(), nullptr, nullptr, const_cast<char**>(argv), environ) != 0)
    throw std::runtime_error(program.string() + ": cannot be started");
  for (int ms = 0; ms < kBeginWithin_ms; ++ms) {
    if (fs::exists(folder_ / "io") && !fs::is_empty(folder_ / "io")) return;
    if (int status = 0; ::waitpid(pid_, &status, WNOHANG) == pid_) break;
    ::usleep(1000);
  }
  pid_ = -1;
  throw std::runtime_error("the simulated lab did not begin");
}

SimulatedInstruments::~SimulatedInstruments() {
  if (pid_ > 0) {
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

PortAddress SimulatedInstruments::address(const std::string& node) const {
  return unix_port((folder_ / "io" / node).string());
}

}  // namespace firn
