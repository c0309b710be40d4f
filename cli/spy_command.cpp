// run_spy starts lcm-spy on a run's bus, with Firn's message types and views.
#include "cli/commands.h"

#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/process/bus_port.h"
#include "print/process/child_process.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/running.h"

extern char** environ;

namespace firn {
namespace {

struct SpyOptions {
  std::string run;  ///< run folder; empty = the newest print that goes on in `runs`
  std::string runs = "runs";
  std::string bus;         ///< LCM URL instead of a run
  std::string screenshot;  ///< PNG of the whole screen, then the end; without a display a virtual one is used
  int layers = 3;          ///< seen before the screenshot
};

namespace fs = std::filesystem;

constexpr const char* kJavaFolder = "/usr/share/java/";
constexpr const char* kVirtualScreen = "1600x1000x24";
constexpr int kDisplayWithinMs = 10'000;
constexpr int kRunWithinS = 10, kLooksPerS = 10;
constexpr int kPictureWithinS = 5;  // of the print's end

bool launcher_runs(const fs::path& run) {
  return fs::exists(RunPaths(run).clocks_path()) && runs::printing_process(run);
}

// The bus of a run that goes on: last word of the last line of `clocks`, which the launcher writes at each
// start.
std::string bus_of(const fs::path& run) {
  const runs::RunFolder folder = runs::RunFolder::open(run);
  if (folder.result() || !launcher_runs(run))
    throw UsageError(run.string() + ": does not print now; firn report " + run.string() +
                     " shows what was printed");
  std::istringstream clocks(read_file(folder.clocks_path()));
  std::string url;
  for (std::string line, word; std::getline(clocks, line);)
    for (std::istringstream words(line); words >> word;) url = word;
  if (url.empty()) throw UsageError(folder.clocks_path().string() + ": names no bus");
  return url;
}

// The newest print that goes on: folder names begin with the time of their start. One that has just been
// started is waited for.
fs::path newest_live_run(const fs::path& runs) {
  for (int tries = 0; tries < kRunWithinS * kLooksPerS; ++tries) {
    fs::path newest;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(runs, error))
      if (launcher_runs(entry.path()) && entry.path().filename() > newest.filename()) newest = entry.path();
    if (!newest.empty()) return newest;
    if (tries == 0) std::fprintf(stderr, "firn: waiting for a print in %s\n", runs.c_str());
    ::usleep(1'000'000 / kLooksPerS);
  }
  throw UsageError("no print goes on in " + runs.string() +
                   "; name a RUN folder, or start one: ./firn print experiments/demo.toml");
}

std::string class_path() {
  std::string path = fs::read_symlink("/proc/self/exe").parent_path() / "firn-spy.jar";
  if (!fs::exists(path)) throw UsageError(path + ": is missing; ./firn spy builds it");
  for (const char* library : {"lcm", "jchart2d", "xmlgraphics-commons", "commons-io"}) {
    const std::string jar = kJavaFolder + std::string(library) + ".jar";
    if (!fs::exists(jar))
      throw UsageError(jar + ": is missing; ./firn spy installs the packages of scripts/packages.txt");
    path += ":" + jar;
  }
  return path;
}

// An X server without a screen, which ends when its last client does. Sets DISPLAY.
std::unique_ptr<ChildProcess> virtual_display() {
  const fs::path program = "/usr/bin/Xvfb";
  if (!fs::exists(program))
    throw UsageError(program.string() + ": is missing; ./firn spy installs its package, xvfb");
  auto server = std::make_unique<ChildProcess>(
      "Xvfb", program,
      std::vector<std::string>{"-displayfd", std::to_string(ChildProcess::kControlFd), "-screen", "0",
                               kVirtualScreen, "-nolisten", "tcp", "-terminate"},
      "/dev/null");
  pollfd ready{server->control().fd(), POLLIN, 0};
  std::optional<std::string> number;
  while (!number && ::poll(&ready, 1, kDisplayWithinMs) > 0 && !server->control().closed())
    number = server->control().next();
  if (!number)
    throw std::runtime_error("Xvfb: gave no display within " + std::to_string(kDisplayWithinMs / 1000) +
                             " s");
  ::setenv("DISPLAY", (":" + *number).c_str(), 1);
  return server;
}

// Exit code of Java. A picture of a run that ends untaken is given up: no message comes any more.
int run_java(std::vector<std::string> arguments, const fs::path& run_of_picture) {
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  pid_t pid = 0;
  if (const int error = ::posix_spawnp(&pid, argv[0], nullptr, nullptr, argv.data(), environ); error != 0)
    throw std::runtime_error(std::string(argv[0]) + ": cannot be started: " + std::strerror(error));
  int status = 0;
  for (int looks_after_end = 0; ::waitpid(pid, &status, run_of_picture.empty() ? 0 : WNOHANG) != pid;) {
    if (run_of_picture.empty()) continue;
    if (!launcher_runs(run_of_picture) && ++looks_after_end > kPictureWithinS * kLooksPerS) {
      ::kill(pid, SIGKILL);
      while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
      }
      throw std::runtime_error(run_of_picture.string() + ": the print ended before the picture was taken");
    }
    ::usleep(1'000'000 / kLooksPerS);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : int(kFailed);
}

/// @throws UsageError: no such run, a run that has ended or was printed in one process, no display, a missing
/// package.
/// @returns the exit code of lcm-spy.
int run_spy(const SpyOptions& o) {
  check_bus(o.bus);
  if (o.bus == "in-process")
    throw UsageError("--bus in-process: a print in one process sends nothing that could be watched");
  const fs::path run = !o.bus.empty()  ? fs::path()
                       : o.run.empty() ? newest_live_run(o.runs)
                                       : fs::path(o.run);
  const std::string bus = run.empty() ? o.bus : bus_of(run);
  if (o.layers < 1) throw UsageError("--layers " + std::to_string(o.layers) + ": must be at least 1");
  std::vector<std::string> java{"java", "-Djava.net.preferIPv4Stack=true", "-cp", class_path(),
                                "firn.spy.Main"};
  std::unique_ptr<ChildProcess> display;
  if (const char* d = ::getenv("DISPLAY"); !d || !*d) {
    if (o.screenshot.empty())
      throw UsageError(
          "no display: set DISPLAY, or take a picture on a virtual screen with --screenshot FILE");
    display = virtual_display();
  }
  if (!o.screenshot.empty()) java.insert(java.end(), {o.screenshot, std::to_string(o.layers)});
  ::setenv("LCM_DEFAULT_URL", bus.c_str(), 1);
  std::fprintf(stderr, "firn: watching %s\n", bus.c_str());
  return run_java(java, o.screenshot.empty() ? fs::path() : run);
}

}  // namespace

void declare_spy(OptionSet& options) {
  auto& o = options.calls(run_spy);
  options.option("RUN", o.run, "folder of a live print; default: the newest that goes on");
  options.runs_option(o.runs, "where run folders are");
  options.option("--bus", o.bus, "LCM URL instead of a run");
  options.option("--screenshot", o.screenshot, "PNG of the screen, then the end; needs no display");
  options.option("--layers", o.layers, "seen before the screenshot").show_default();
}

}  // namespace firn
