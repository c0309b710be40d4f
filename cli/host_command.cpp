// run_host serves a print that another computer's launcher runs: the processes that its lab file puts here.
#include "cli/commands.h"

#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/hosts/at_host.h"
#include "print/hosts/far_end.h"
#include "print/hosts/lane.h"

namespace firn {
namespace {

struct HostOptions {
  std::string runs;  ///< empty: FarEnd::default_runs()
  std::string lab;   ///< in hexadecimal digits, with command: a command for one of its instruments here
  std::vector<std::string> files;    ///< beside the lab's: NAME:digits
  std::vector<std::string> command;  ///< and its words
  std::string lane;  ///< of the firn host that it joins; empty: this one serves a print itself
};

/// @throws UsageError: a terminal is no relay
int run_host(const HostOptions& o) {
  if (!o.lab.empty()) {
    if (o.command.empty()) throw UsageError("--lab: a command is wanted");
    return run_here(o.lab, o.files, o.command.front(), {o.command.begin() + 1, o.command.end()});
  }
  if (::isatty(STDIN_FILENO))
    throw UsageError(
        "firn host is started by the launcher of a print, by ssh, and not by hand; docs/hosts.md");
  for (const int ignored : {SIGPIPE, SIGHUP, SIGINT, SIGXFSZ}) std::signal(ignored, SIG_IGN);
  if (!o.lane.empty()) {
    carry_lane(o.lane);
    return kOk;
  }
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
  options.option("--lane", o.lane, "a further connection for the firn host that named it");
  options.option("--runs", o.runs, "folder of the records of prints; default: ~/.local/state/firn/hosts");
}

}  // namespace firn
