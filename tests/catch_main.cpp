// The main of every test program: Catch2's own, from its package, in which a test case without an assertion
// fails and so does a run without tests; skipped tests have a status of their own. Temporary files lie in a
// folder of the program's own, since tests run beside each other and may choose the same name.
#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <stdlib.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "tests/support/skip.h"

// The linker's --wrap (tests/CMakeLists.txt) makes the first of these the program's entry and gives the
// second name to Catch2's.
extern "C" int __wrap_main(int argc, char** argv);
extern "C" int __real_main(int argc, char** argv);

namespace firn::test {
namespace {

bool any_skipped = false, none_ran = false;

struct CountTests : Catch::TestEventListenerBase {
  using Catch::TestEventListenerBase::TestEventListenerBase;
  void testRunEnded(const Catch::TestRunStats& run) override { none_ran = run.totals.testCases.total() == 0; }
};

template <class Run>
int with_own_tmpdir(const Run& run) {
  // Sockets lie below it, and their paths are at most 107 bytes long: the name is short.
  std::string folder = (std::filesystem::temp_directory_path() / "t-XXXXXX").string();
  if (!::mkdtemp(folder.data())) {
    std::perror(folder.c_str());
    return 2;
  }
  ::setenv("TMPDIR", folder.c_str(), 1);
  const int status = run();
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return status;
}

}  // namespace

CATCH_REGISTER_LISTENER(CountTests)

void skip(const std::string& name, const std::string& reason) {
  any_skipped = true;
  std::printf("skipped: %s: %s\n", name.c_str(), reason.c_str());
  std::fflush(stdout);
  SUCCEED("skipped");  // a test case without an assertion would fail
}

}  // namespace firn::test

int __wrap_main(int argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  char warn[] = "--warn", no_assertions[] = "NoAssertions";
  arguments.insert(arguments.end(), {warn, no_assertions, nullptr});
  const int failed = firn::test::with_own_tmpdir([&] { return __real_main(argc + 2, arguments.data()); });
  if (failed) return failed;
  if (firn::test::none_ran) return 2;
  return firn::test::any_skipped ? firn::test::kSkippedStatus : 0;
}
