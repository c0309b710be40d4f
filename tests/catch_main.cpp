#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/support/skip.h"

namespace firn::test {
namespace {

bool any_skipped = false;

}  // namespace

void skip(const std::string& name, const std::string& reason) {
  any_skipped = true;
  std::printf("skipped: %s: %s\n", name.c_str(), reason.c_str());
  std::fflush(stdout);
  SUCCEED("skipped");  // a test case without an assertion would fail
}

}  // namespace firn::test

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int refused = session.applyCommandLine(argc, argv)) return refused;
  Catch::ConfigData& config = session.configData();
  config.warnings =
      Catch::WarnAbout::What(config.warnings | Catch::WarnAbout::NoAssertions);  // such a test fails
  const int failed = session.run();
  return failed == 0 && firn::test::any_skipped ? firn::test::kSkippedStatus : failed;
}
