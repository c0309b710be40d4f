// firn: one program, one file per subcommand. Data on stdout, progress and errors on stderr.
#include <csignal>
#include <cstdio>
#include <exception>

#include "cli/failure.h"
#include "cli/options.h"
#include "files/record/part_file.h"

int main(int argc, char** argv) {
  using namespace firn;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of write(), not the end
  logfile::remove_parts_on_signals();
  const Call call = parse_command_line(commands(), argc, argv);
  try {
    return call.run();
  } catch (const std::exception& e) {
    const Failure f = failure_of(e);
    std::fprintf(stderr, "firn%s%s: %s\n", call.command.empty() ? "" : " ", call.command.c_str(),
                 f.line.c_str());
    return f.code;
  }
}
