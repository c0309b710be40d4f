#include "cli/program.h"

#include <csignal>
#include <cstdio>
#include <exception>

#include "cli/failure.h"
#include "cli/options.h"
#include "files/record/part_file.h"

namespace firn {

int run_program(std::span<const Command> commands, const Product& product, int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of write(), not the end
  record::remove_parts_on_signals();
  const Call call = parse_command_line(commands, product, argc, argv);
  try {
    return call.run();
  } catch (const std::exception& e) {
    const Failure f = failure_of(e);
    std::fprintf(stderr, "firn%s%s: %s\n", call.command.empty() ? "" : " ", call.command.c_str(),
                 f.line.c_str());
    return f.code;
  }
}

}  // namespace firn
