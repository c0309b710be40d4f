// The promise of replay: equal bytes within a minor version (docs/decisions/0012-replay-contract.md).
#include <catch2/catch.hpp>

#include "replay/promise.h"

namespace firn::replay {
namespace {

TEST_CASE("A run of the same minor version is within the promise of replay, whatever its patch") {
  CHECK(beyond_promise("0.2.0", "abc", "0.2.0").empty());
  CHECK(beyond_promise("0.2.7", "abc", "0.2.0").empty());
  CHECK(beyond_promise("1.10.0", "abc", "1.10.3").empty());
}

TEST_CASE("A run of another version is told with the version and the commit that replay it") {
  for (const char* other : {"0.1.9", "0.20.0", "1.2.0", "0.3.0"}) {
    INFO(other);
    const std::string text = beyond_promise(other, "0123abc", "0.2.0");
    CHECK(text.find(std::string("Firn ") + other) != std::string::npos);
    CHECK(text.find("git checkout 0123abc && ./firn replay RUN") != std::string::npos);
  }
}

TEST_CASE("A run without a version is older than all versions, and changed sources are applied first") {
  const std::string text = beyond_promise("", "0123abc-dirty-99ff", "0.2.0");
  CHECK(text.find("before version 0.2") != std::string::npos);
  CHECK(text.find("git checkout 0123abc && git apply RUN/sources.diff && ./firn replay RUN") !=
        std::string::npos);
}

}  // namespace
}  // namespace firn::replay
