// run_view shows recorded and running prints in a browser.
#include "cli/commands.h"

#include <fmt/core.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/user_config.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "page/server.h"
#include "print/operator/page_token.h"
#include "runs/find/run_index.h"
#include "runs/folder/address.h"
#include "runs/folder/run_folder.h"

namespace firn {
namespace {

struct ViewOptions {
  std::vector<std::string> runs;  ///< run folders, and folders of run folders; none: default_runs_folder()
  std::string bind = "127.0.0.1";
  bool is_public = false;
  int port = 0;  ///< 0: the first free one
  std::vector<std::string> hosts;
  std::string people;  ///< empty: people_table()
  bool json = false;
};

// Readable when Ctrl-C was pressed.
class StopSignal {
 public:
  StopSignal() {
    sigset_t stop;
    sigemptyset(&stop);
    sigaddset(&stop, SIGINT);
    sigaddset(&stop, SIGTERM);
    ::sigprocmask(SIG_BLOCK, &stop, nullptr);
    fd_ = ::signalfd(-1, &stop, SFD_CLOEXEC);
  }
  ~StopSignal() { ::close(fd_); }
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_ = -1;
};

/// Serves until Ctrl-C. @throws UsageError: no such folder, an address that is none, a port in use
int run_view(const Product& product, const ViewOptions& o) {
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignal stop;
  page::ServerOptions s;
  s.places.assign(o.runs.begin(), o.runs.end());
  if (s.places.empty()) {
    s.places.emplace_back(default_runs_folder().folder);
    std::filesystem::create_directories(s.places.front());  // before the first print: an empty list
  }
  s.bind = o.bind;
  s.port = o.port;
  s.hosts = o.hosts;
  s.token = new_page_token();
  s.is_public = o.is_public;
  s.people = o.people.empty() ? people_table() : std::filesystem::path(o.people);
  s.stop_fd = stop.fd();
  s.index = runs::user_index();
  std::string open;  // the one run that was named
  if (o.runs.size() == 1 && runs::is_run(s.places[0])) open = runs::address_of(s.places[0]).text();
  s.listening = [&](const std::string& address) {
    const std::string whole = address + "#token=" + s.token + (open.empty() ? "" : "&run=" + open);
    if (o.json)
      fmt::print("{}\n",
                 nlohmann::ordered_json{{"address", address}, {"token", s.token}, {"url", whole}}.dump());
    else
      fmt::print("{}\nCtrl-C ends it; docs/page.md says how others may see it\n", whole);
    std::fflush(stdout);
  };
  page::serve(product, s);
  return kOk;
}

}  // namespace

void declare_view(OptionSet& options) {
  auto& o = options.calls(run_view);
  options.option("RUN", o.runs,
                 "run folders, and folders of run folders; default: FIRN_RUNS, your configuration, runs");
  options.option("--port", o.port, "default: the first free one from 8750 on").within(1, 65535);
  options
      .option("--bind", o.bind,
              "address to listen on; beyond 127.0.0.1 put a proxy with TLS before it; docs/page.md")
      .show_default();
  options.option("--host", o.hosts, "NAME[:PORT] under which a proxy offers the page").one_value_each();
  options.flag("--public", o.is_public,
               "who reaches the page may read without the token; commands ask for it");
  options.option("--people", o.people,
                 "table of those who have tokens of their own; default: that of firn people");
  options.json_flag(o.json);
}

}  // namespace firn
