// The main of every test program: Catch2's own, from its package, in which a test case without an assertion
// fails and so does a run without tests; skipped tests have a status of their own.
#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <cstdio>
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
  const int failed = __real_main(argc + 2, arguments.data());
  if (failed) return failed;
  if (firn::test::none_ran) return 2;
  return firn::test::any_skipped ? firn::test::kSkippedStatus : 0;
}
