#include <catch2/catch.hpp>
#include <optional>
#include <random>
#include <string>

#include "tests/support/long_cases.h"

namespace firn::test {
namespace {

/// FIRN_FULL of a run, put back at the end.
class Run {
 public:
  explicit Run(const char* full) {
    if (const char* value = std::getenv("FIRN_FULL")) before_ = value;
    set(full);
  }
  ~Run() { set(before_ ? before_->c_str() : nullptr); }

 private:
  static void set(const char* value) { value ? ::setenv("FIRN_FULL", value, 1) : ::unsetenv("FIRN_FULL"); }
  std::optional<std::string> before_;
};

}  // namespace

TEST_CASE("a long loop runs the same few cases every time, evenly spread") {
  const Run usual(nullptr);
  CHECK(long_cases(57, 4) == std::vector<std::size_t>{0, 14, 28, 42});
  CHECK(long_cases(57, 4) == long_cases(57, 4));
  CHECK(long_cases(std::vector<int>{7, 8, 9}, 2) == std::vector<int>{7, 8});
  CHECK(long_cases(std::vector<int>{7, 8, 9}, 1) == std::vector<int>{7});
}

TEST_CASE("FIRN_FULL runs every case of a long loop once") {
  const Run all("1");
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = random() % 1000;
    const std::vector<std::size_t> cases = long_cases(count, random() % 20);
    REQUIRE(cases.size() == count);
    for (std::size_t n = 0; n < count; ++n) REQUIRE(cases[n] == n);
  }
}

TEST_CASE("a loop that is shorter than the few cases runs whole") {
  const Run usual(nullptr);
  CHECK(long_cases(3, 8) == std::vector<std::size_t>{0, 1, 2});
  CHECK(long_cases(0, 8).empty());
}

}  // namespace firn::test
