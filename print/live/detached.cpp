#include "print/live/detached.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <stdexcept>

#include "print/operator/operator_client.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr int kLookUs = 20'000;

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

pid_t spawn(const fs::path& program, const std::vector<std::string>& words, const fs::path& output) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawnattr_t how;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                   0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_init(&how);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSID);
  pid_t pid = -1;
  const int error = ::posix_spawn(&pid, program.c_str(), &files, &how, argv.data(), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::runtime_error(program.string() + ": cannot be started: " + std::strerror(error));
  return pid;
}

}  // namespace

DetachedPrint start_detached(const fs::path& run, const std::vector<std::string>& words) {
  const fs::path output = run / "print.out";
  const DetachedPrint print{spawn(fs::read_symlink("/proc/self/exe"), words, output)};
  for (int status = 0; !OperatorClient::answers(run); ::usleep(kLookUs))
    if (::waitpid(print.pid, &status, WNOHANG) == print.pid) {
      if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;  // a part of no layers
      throw std::runtime_error(output.string() + ": the print did not start: " + last_line(output));
    }
  return print;
}

}  // namespace firn
