// run_host serves a print that another computer's launcher runs: the processes that its lab file puts here.
// With --install it copies this build to the other computers of a lab.
#include "cli/commands.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/device/lab_experiment.h"
#include "print/hosts/at_host.h"
#include "print/hosts/far_end.h"
#include "print/hosts/install_build.h"
#include "print/hosts/lane.h"
#include "procs/relay/hello.h"
#include "runtime/precedence.h"

namespace firn {
namespace {

struct HostOptions {
  std::string runs;  ///< empty: FarEnd::default_runs()
  std::string lab;   ///< in hexadecimal digits, with command: a command for one of its instruments here
  std::vector<std::string> files;    ///< beside the lab's: NAME:digits
  std::vector<std::string> command;  ///< and its words
  std::string install;               ///< lab file: copy this build to its hosts
  std::string host;                  ///< with install: to this one alone
  std::string lane;  ///< of the firn host that it joins; empty: this one serves a print itself
};

/// @returns kOk, or kSafetyStop if a computer did not take it
int install(const HostOptions& o) {
  const Experiment lab = load_lab_experiment(o.install, {});
  if (lab.hosts.address.empty()) throw UsageError(o.install + ": has no [hosts]; docs/hosts.md");
  if (!o.host.empty() && !lab.hosts.address.contains(o.host))
    throw UsageError(o.install + ": [hosts] has no '" + o.host + "'");
  const std::filesystem::path home =
      std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
  int status = kOk;
  for (const auto& [name, text] : lab.hosts.address) {
    if (!o.host.empty() && o.host != name) continue;
    const relay::HostPlace place = relay::place_of(text);
    std::fprintf(stderr, "host %s: copying\n", name.c_str());
    try {
      const InstalledBuild build = install_build(place.address, home);
      std::printf("host %s: %s is %s\n", name.c_str(), build.program.c_str(), build.name.c_str());
      if (place.program != build.program)
        std::printf("  write into [hosts]: %s = \"%s:%s\"\n", name.c_str(), place.address.c_str(),
                    build.program.c_str());
    } catch (const std::runtime_error& e) {
      std::fprintf(stderr, "host %s (%s) %s\n", name.c_str(), place.address.c_str(), e.what());
      status = kSafetyStop;
    }
  }
  return status;
}

/// @throws UsageError: a terminal is no relay
int run_host(const HostOptions& o) {
  if (!o.install.empty()) return install(o);
  if (!o.lab.empty()) {
    if (o.command.empty()) throw UsageError("--lab: a command is wanted");
    return run_here(o.lab, o.files, o.command.front(), {o.command.begin() + 1, o.command.end()});
  }
  if (::isatty(STDIN_FILENO))
    throw UsageError(
        "firn host is started by the launcher of a print, by ssh, and not by hand; docs/hosts.md");
  for (const int ignored : {SIGPIPE, SIGHUP, SIGINT, SIGXFSZ}) std::signal(ignored, SIG_IGN);
  if (!o.lane.empty()) {
    const Precedence precedence;
    carry_lane(o.lane);
    return kOk;
  }
  const Precedence precedence;  // leases and stops pass through it
  const std::filesystem::path programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return FarEnd(o.runs.empty() ? FarEnd::default_runs() : std::filesystem::path(o.runs), programs)
      .run(::dup(STDIN_FILENO), ::dup(STDOUT_FILENO));
}

}  // namespace

void declare_host(OptionSet& options) {
  auto& o = options.calls(run_host);
  options.option("--lab", o.lab, "lab of another computer, in hexadecimal digits");
  options.option("--file", o.files, "with --lab: NAME:DIGITS, a file that it names").one_value_each();
  options.option("COMMAND", o.command,
                 "with --lab: a command for an instrument that is here, and its words, behind --");
  options.option("--install", o.install,
                 "copy this build to the hosts of this lab file, into the user's own folder");
  options.option("--host", o.host, "with --install: to this host alone");
  options.option("--lane", o.lane, "a further connection for the firn host that named it");
  options.option("--runs", o.runs, "folder of the records of prints; default: ~/.local/state/firn/hosts");
}

}  // namespace firn
