#include "studies/engines/parallel.h"

#include <map>
#include <sstream>

#include "files/command.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr const char* kProgram = "parallel";

[[noreturn]] void missing() {
  throw UsageError("GNU parallel is not installed here: apt-get install parallel");
}

}  // namespace

void Parallel::check(const std::string& program, const std::string& version) {
  const std::string question = shell_word(program) + " --version; test -e " +
                               shell_word((folder_ / "study.toml").string()) +
                               " && echo shared || echo apart";
  const CommandEnd end =
      run_command({kProgram, "--will-cite", "--nonall", "--tag", "--sshlogin", hosts_, question});
  if (end.missing()) missing();
  struct Host {
    bool same_build = false, shared = false;
    std::string said;
  };
  std::map<std::string, Host> hosts;
  std::istringstream lines(end.output);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t tab = line.find('\t');
    if (tab == std::string::npos) continue;
    Host& host = hosts[line.substr(0, tab)];
    const std::string said = line.substr(tab + 1);
    if (said == version)
      host.same_build = true;
    else if (said == "shared")
      host.shared = true;
    else if (said != "apart")
      host.said = said;
  }
  if (end.code != 0 || hosts.empty()) throw UsageError("--on ssh:" + hosts_ + ": " + end.reason());
  for (const auto& [name, host] : hosts) {
    if (!host.same_build)
      throw UsageError(name + ": " + (host.said.empty() ? "no firn at " + program : "runs " + host.said) +
                       "; this is " + version + ": one build on all computers is wanted, at the same path");
    shared_ = shared_ && host.shared;
  }
}

int Parallel::run(const ShardCommand& command, const std::atomic<bool>& stop) const {
  const std::filesystem::path log = write_engine_file(folder_ / "parallel", "job.log", "");
  std::vector<std::string> words{kProgram,   "--will-cite", "--sshlogin",
                                 hosts_,     "--retries",   "3",  // on another computer where one dies
                                 "--joblog", log.string()};
  if (!shared_) {
    words.push_back("--return");
    words.push_back((folder_ / "shards" / ("{}-of-" + std::to_string(command.shards) + ".journal")).string());
  }
  words.push_back(command.line("{}") + " --threads 1");
  words.push_back(":::");
  for (const int shard : command.wanted) words.push_back(std::to_string(shard));
  const CommandEnd end = run_command(words, &stop);
  if (end.missing()) missing();
  write_engine_file(folder_ / "parallel", "errors.txt", end.errors);
  return end.code;
}

}  // namespace firn
