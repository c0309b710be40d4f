#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "tests/support/long_cases.h"

namespace firn::test {
namespace {

/// Environment of a run, put back at the end.
class Run {
 public:
  Run(const char* full, const char* tenth) : full_(kept("FIRN_FULL")), tenth_(kept("FIRN_TENTH")) {
    set("FIRN_FULL", full);
    set("FIRN_TENTH", tenth);
  }
  ~Run() {
    set("FIRN_FULL", full_ ? full_->c_str() : nullptr);
    set("FIRN_TENTH", tenth_ ? tenth_->c_str() : nullptr);
  }

 private:
  static std::optional<std::string> kept(const char* name) {
    const char* value = std::getenv(name);
    return value ? std::optional<std::string>(value) : std::nullopt;
  }
  static void set(const char* name, const char* value) {
    value ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  std::optional<std::string> full_, tenth_;
};

std::vector<std::size_t> numbers(Stride stride, std::size_t end) {
  std::vector<std::size_t> all;
  for (std::size_t n = stride.first; n < end; n += stride.step) all.push_back(n);
  return all;
}

constexpr const char* kTenths[] = {"0", "1", "2", "3", "4", "5", "6", "7", "8", "9"};

}  // namespace

TEST_CASE(
    "ten tenths of a long loop run every case once, and none is more than one case longer than another") {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    const std::size_t all = random() % 1000, few = all == 0 ? 0 : random() % all;
    std::map<std::size_t, int> ran;
    for (const char* tenth : kTenths) {
      const Run day(nullptr, tenth);
      const std::vector<std::size_t> cases = long_cases(all, few);
      CHECK(cases.size() >= all / 10);
      CHECK(cases.size() <= (all + 9) / 10);
      for (const std::size_t n : cases) ++ran[n];
    }
    CHECK(ran.size() == all);
    for (const auto& [n, times] : ran) REQUIRE((n < all && times == 1));
  }
}

TEST_CASE("ten tenths of a stride run every one of its numbers once") {
  for (const std::size_t first : {0, 1, 10})
    for (const std::size_t step : {1, 3, 20}) {
      std::vector<std::size_t> ran;
      for (const char* tenth : kTenths) {
        const Run day(nullptr, tenth);
        for (const std::size_t n : numbers(long_stride({first, step}, {7, 5}), 1234)) ran.push_back(n);
      }
      std::sort(ran.begin(), ran.end());
      CHECK(ran == numbers({first, step}, 1234));
    }
}

TEST_CASE("FIRN_FULL runs all cases whatever the tenth, and a run with neither the first few") {
  for (const char* tenth : {"3", "none"}) {
    const Run all("1", tenth);
    CHECK(long_cases(57, 4).size() == 57);
    CHECK(long_stride({1, 2}, {3, 4}).first == 1);
  }
  for (const char* none : {"none", static_cast<const char*>(nullptr)}) {
    const Run few(nullptr, none);
    CHECK(long_cases(57, 4) == std::vector<std::size_t>{0, 1, 2, 3});
    CHECK(long_stride({1, 2}, {3, 4}).step == 4);
    CHECK(long_cases(std::vector<int>{7, 8, 9}, 2) == std::vector<int>{7, 8});
  }
  const Run third(nullptr, "2");
  CHECK(long_cases(std::vector<int>{7, 8, 9}, 2) == std::vector<int>{9});
}

TEST_CASE("a tenth that is no digit is refused by its text") {
  for (const char* bad : {"10", "x", "", "-1"}) {
    const Run day(nullptr, bad);
    CHECK_THROWS_WITH(long_cases(5, 5), "FIRN_TENTH: '" + std::string(bad) + "' is neither a digit nor none");
  }
}

}  // namespace firn::test
