#include "files/command.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "core/grid/random.h"

using namespace firn;

TEST_CASE("A program's exit code, output and errors come back apart") {
  const CommandEnd end = run_command({"sh", "-c", "echo out; echo first >&2; echo last >&2; exit 3"});
  CHECK(end.code == 3);
  CHECK(end.output == "out\n");
  CHECK(end.errors == "first\nlast\n");
  CHECK(end.reason() == "last");
  CHECK(run_command({"sh", "-c", "exit 4"}).reason() == "exit code 4");
  CHECK(run_command({"sh", "-c", "kill -9 $$"}).code == 128 + 9);
}

TEST_CASE("An output longer than any pipe comes back whole") {
  CHECK(run_command({"sh", "-c", "head -c 3000000 /dev/zero"}).output.size() == 3'000'000);
}

TEST_CASE("A program that is not installed is missing, not an exception") {
  CHECK(run_command({"firn-no-such-program"}).missing());
}

TEST_CASE("A program that is told to stop ends, also one that wants two signals") {
  std::atomic<bool> stop{false};
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop = true;
  });
  const CommandEnd end = run_command(
      {"sh", "-c", "n=0; trap 'n=$((n+1)); [ $n -lt 2 ] || exit 9' TERM; while :; do sleep 0.05; done"},
      &stop);
  later.join();
  CHECK(end.code == 9);
}

TEST_CASE("A shell reads a word as it was, whatever bytes it has") {
  RandomStream random(4, Purpose::kTest);
  for (int n = 0; n < 50; ++n) {
    std::string word;
    for (std::uint32_t k = random.below(12); k > 0; --k) word += " '\"$`\\a\n*?~-=%,{}"[random.below(17)];
    INFO(word);
    CHECK(run_command({"sh", "-c", "printf %s " + shell_word(word)}).output == word);
  }
}
