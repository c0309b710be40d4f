#include "cli/notify.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

std::string host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string event_of(const runs::RunResult& result) {
  if (result.outcome == "waits for operator") return "needs a person";
  if (result.status == kOk) return "finished";
  if (result.status == kOutOfTolerance) return "out of tolerance";
  return "stopped";
}

// A file without a name that holds the text, to be read from its beginning.
int file_of(const std::string& text) {
  const int fd = ::memfd_create("event", MFD_CLOEXEC);
  if (fd < 0) return -1;
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n <= 0) break;
    done += std::size_t(n);
  }
  ::lseek(fd, 0, SEEK_SET);
  return fd;
}

// @param quiet its output goes nowhere. @returns 0 and the process, or the number of the error
int start(const std::string& command, const std::string& event, bool quiet, pid_t& pid) {
  const int input = file_of(event + "\n");
  if (input < 0) return errno;
  posix_spawn_file_actions_t files;
  posix_spawnattr_t how;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  if (quiet) {
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  }
  posix_spawnattr_init(&how);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSID);
  const char* words[] = {"sh", "-c", command.c_str(), nullptr};
  const int error = ::posix_spawn(&pid, "/bin/sh", &files, &how, const_cast<char**>(words), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&files);
  ::close(input);
  return error;
}

}  // namespace

std::string notice_of(const PrintSummary& print) {
  const runs::RunResult& r = print.result;
  const std::filesystem::path run = std::filesystem::absolute(print.folder);
  const std::string event = event_of(r);
  Json j{{"version", kVersion},
         {"event", event},
         {"text", fmt::format("{} on {}: {}{}", run.filename().string(), host(), event,
                              event == "finished" ? "" : ": " + for_people(r.reason))},
         {"run", run.string()},
         {"host", host()},
         {"outcome", r.outcome},
         {"reason", r.reason},
         {"status", r.status},
         {"layers", r.layers}};
  j["rms_um"] = r.error ? Json(r.error->rms_um) : Json(nullptr);
  j["tolerance_um"] = r.tolerance_um ? Json(*r.tolerance_um) : Json(nullptr);
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void send_notice(const std::string& command, const std::string& event) {
  pid_t pid = -1;
  if (const int error = start(command, event, true, pid); error != 0)
    fmt::print(stderr, "notify.command cannot be started: {}\n", std::strerror(error));
}

int try_notice(const std::string& command) {
  const Json event{{"version", kVersion},
                   {"event", "test"},
                   {"text", "firn on " + host() + ": this is how a print would tell its end"},
                   {"run", nullptr},
                   {"host", host()}};
  pid_t pid = -1;
  if (const int error = start(command, event.dump(), false, pid); error != 0)
    throw UsageError(std::string("notify.command cannot be started: ") + std::strerror(error));
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace firn
