// firn: one program, one file per subcommand. Data on stdout, progress and errors on stderr.
#include <csignal>
#include <cstdio>
#include <exception>

#include "cli/options.h"
#include "config/error.h"
#include "files/record/part_file.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"

int main(int argc, char** argv) {
  using namespace firn;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of write(), not the end
  logfile::remove_parts_on_signals();
  const Call call = parse_command_line(commands(), argc, argv);
  const auto report = [&](const char* what, int code) {
    std::fprintf(stderr, "firn%s%s: %s\n", call.command.empty() ? "" : " ", call.command.c_str(), what);
    return code;
  };
  try {
    return call.run();
  } catch (const ConfigError& e) {
    return report(e.what(), kUsage);
  } catch (const UsageError& e) {
    return report(e.what(), kUsage);
  } catch (const std::exception& e) {
    return report(e.what(), kFailed);
  }
}
