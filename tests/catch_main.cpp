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
}

}  // namespace firn::test

int main(int argc, char** argv) {
  const int failed = Catch::Session().run(argc, argv);
  return failed == 0 && firn::test::any_skipped ? firn::test::kSkippedStatus : failed;
}
