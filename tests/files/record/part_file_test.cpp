// Unfinished outputs and the signals that end a program.
#include "files/record/part_file.h"

#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <csignal>
#include <fstream>

#include "files/record/named_record_file.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using namespace firn::test;
using namespace firn::record;
namespace fs = std::filesystem;

namespace {

// Runs `work` in a child that then waits, ends the child by `signal`. @returns its wait status
template <class Work>
int ended_by(int signal, const Work& work) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t pid = ::fork();
  if (pid == 0) {
    record::remove_parts_on_signals();
    work([&] {
      const char ready = 1;
      static_cast<void>(::write(ends[1], &ready, 1) == 1);
      for (;;) ::pause();
    });
    ::_exit(0);
  }
  ::close(ends[1]);
  char ready = 0;
  CHECK(::read(ends[0], &ready, 1) == 1);
  ::close(ends[0]);
  ::kill(pid, signal);
  int status = 0;
  ::waitpid(pid, &status, 0);
  return status;
}

}  // namespace

TEST_CASE("A signal that ends the program removes its unfinished outputs and nothing else") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    CAPTURE(signal);
    const Scratch scratch("part-file");
    const auto before = std::signal(signal, SIG_DFL);
    const int status = ended_by(signal, [&](const auto& wait) {
      std::ofstream(scratch / "finished") << "x";
      { const record::PartFile finished(scratch / "finished"); }
      const record::PartFile part(scratch / "a.part");
      std::ofstream(part.path()) << "x";
      record::NamedRecordFile record(scratch / "b");
      wait();
    });
    std::signal(signal, before);
    CHECK((WIFSIGNALED(status) && WTERMSIG(status) == signal));
    std::vector<std::string> left;
    for (const auto& entry : fs::directory_iterator(scratch / "")) left.push_back(entry.path().filename());
    CHECK(left == std::vector<std::string>{"finished"});
  }
}

TEST_CASE("A signal in a forked child leaves its parent's unfinished outputs alone") {
  const Scratch scratch("part-file-child");
  const auto before = std::signal(SIGTERM, SIG_DFL);
  const int status = ended_by(SIGTERM, [&](const auto& wait) {
    const record::PartFile part(scratch / "a.part");
    std::ofstream(part.path()) << "x";
    const pid_t pid = ::fork();
    if (pid == 0) ::raise(SIGTERM);
    ::waitpid(pid, nullptr, 0);
    if (!fs::exists(part.path())) ::_exit(1);
    wait();
  });
  std::signal(SIGTERM, before);
  CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM));
}

TEST_CASE("An ignored signal stays ignored") {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const pid_t pid = ::fork();
  if (pid == 0) {
    record::remove_parts_on_signals();
    ::raise(SIGHUP);
    ::_exit(7);
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  std::signal(SIGHUP, before);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 7));
}
