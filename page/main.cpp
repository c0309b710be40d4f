// The process `page` shows one print to browsers; the launcher never waits for it. Arguments: --run DIR
// --control-fd N. Down the line come "PUBLIC", "PEOPLE FILE", then "TOKEN DIGITS"; up goes "PAGE ADDRESS".
#include <poll.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

#include "core/options/arguments.h"
#include "page/server.h"
#include "print/labs/full_product.h"
#include "runtime/control_line.h"

namespace {

// It goes first when there is no memory left; serve() gives way with the processor. Its thread for commands
// may be scheduled in real time: a second of that without a pause ends the process.
void give_way() {
  const rlimit second{1'000'000, 1'000'000};  // us
  ::setrlimit(RLIMIT_RTTIME, &second);
  for (const int signal : {SIGINT, SIGHUP, SIGPIPE, SIGTSTP}) std::signal(signal, SIG_IGN);
  std::ofstream("/proc/self/oom_score_adj") << "900";
}

void take_rights(firn::ControlLine& control, firn::page::ServerOptions& options) {
  while (options.token.empty()) {
    pollfd readable{control.fd(), POLLIN, 0};
    ::poll(&readable, 1, -1);
    while (const auto line = control.next()) {
      if (*line == "PUBLIC") options.is_public = true;
      if (line->starts_with("PEOPLE ")) options.people = line->substr(7);
      if (line->starts_with("TOKEN ")) options.token = line->substr(6);
    }
    if (control.closed()) throw std::runtime_error("no token came");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string words[] = {argc > 1 ? argv[1] : "", argc > 3 ? argv[3] : ""};
  if (argc != 5 || words[0] != "--run" || words[1] != "--control-fd")
    throw std::runtime_error("wanted: --run DIR --control-fd N");
  give_way();
  firn::ControlLine control(firn::argument_number<std::int32_t>(words[1], argv[4]));
  firn::page::ServerOptions options;
  options.live = argv[2];
  options.places = {std::filesystem::absolute(options.live).parent_path()};
  take_rights(control, options);
  options.stop_fd = control.fd();
  options.listening = [&](const std::string& address) { control.say("PAGE " + address); };
  firn::page::serve(firn::full_product(), options);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "page: %s\n", e.what());
  return 1;
}
