#include "tests/live/far_hosts.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "files/command.h"

extern char** environ;

namespace firn::test {
namespace {

const std::string kScript = FIRN_SOURCE_DIR "/tests/support/far_hosts.py";

}  // namespace

std::string FarHosts::refused() {
  std::string why = run_command({"python3", "-B", kScript, "refused"}).output;
  while (!why.empty() && why.back() == '\n') why.pop_back();
  return why;
}

FarHosts::FarHosts(const std::vector<std::string>& names) {
  char place[] = "/tmp/firn-hosts-XXXXXX";
  if (!::mkdtemp(place)) throw std::runtime_error("mkdtemp");
  folder_ = place;
  int down[2], up[2];
  if (::pipe2(down, O_CLOEXEC) != 0 || ::pipe2(up, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  std::vector<std::string> words{"python3", "-B", kScript, folder_.string()};
  words.insert(words.end(), names.begin(), names.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, down[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, up[1], STDOUT_FILENO);
  const int error = ::posix_spawnp(&pid_, "python3", &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  ::close(down[0]);
  ::close(up[1]);
  if (error != 0) throw std::runtime_error("python3 cannot be started");
  to_ = ::fdopen(down[1], "w");
  from_ = ::fdopen(up[0], "r");
  if (!answer().starts_with("ready")) throw std::runtime_error("no hosts were made");
  path_before_ = std::getenv("PATH");
  ::setenv("PATH", (folder_.string() + ":" + path_before_).c_str(), 1);
}

FarHosts::~FarHosts() {
  ::setenv("PATH", path_before_.c_str(), 1);
  std::fclose(to_);
  ::waitpid(pid_, nullptr, 0);
  std::fclose(from_);
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void FarHosts::line(const std::string& host, double delay_s, double jitter_s, double loss) {
  order("line " + host + " " + std::to_string(delay_s) + " " + std::to_string(jitter_s) + " " +
        std::to_string(loss));
}

std::vector<int> FarHosts::pids(const std::string& host) {
  std::istringstream in(order("pids " + host));
  std::vector<int> all;
  for (int pid = 0; in >> pid;) all.push_back(pid);
  return all;
}

std::string FarHosts::order(const std::string& line) {
  std::fprintf(to_, "%s\n", line.c_str());
  std::fflush(to_);
  return answer();
}

std::string FarHosts::answer() {
  char text[4096] = {};
  if (!std::fgets(text, sizeof text, from_)) throw std::runtime_error("the hosts are gone");
  return text;
}

std::string FarHosts::firn_elsewhere() const {
  const std::filesystem::path boot = folder_ / "boot_id", script = folder_ / "firn-elsewhere";
  std::ofstream(boot) << "6b1f0c1e-0000-4000-8000-000000000054\n";
  std::ofstream(script) << "#!/bin/sh\nexec unshare --mount sh -c 'mount --bind " << boot.string()
                        << " /proc/sys/kernel/random/boot_id && exec " FIRN_BINARY_DIR
                           "/bin/firn \"$@\"' firn \"$@\"\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  return script.string();
}

std::string FarHosts::firn_with(const std::string& variables, int days) const {
  const std::filesystem::path script = folder_ / "firn-with";
  const std::string ahead = std::to_string(std::int64_t(days) * 86'400);
  const std::string clocks =
      days == 0 ? "" : "unshare --time --monotonic " + ahead + " --boottime " + ahead + " --fork ";
  std::ofstream(script) << "#!/bin/sh\nexec " << clocks << "env " << variables
                        << " " FIRN_BINARY_DIR "/bin/firn \"$@\"\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  return script.string();
}

}  // namespace firn::test
