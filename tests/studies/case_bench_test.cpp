// Cases of a bench as a study: in shards, resumed, failed.
#include "tests/bench/case_bench.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "files/exit_codes.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::bench;

namespace {

struct CaseCalls {
  /// @param words of the command line
  std::optional<std::vector<CaseBench::Result>> run(std::vector<std::string> words) {
    CaseBench bench("imagined", "imagined cases");
    words.insert(words.begin(), "imagined");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    if (const auto said = bench.parse(int(argv.size()), argv.data())) {
      code = *said;
      return std::nullopt;
    }
    bench.study.threads = 1;
    Cases cases{"imagined", "settings", {"plain", "odd"}, {1, 2, 3, 4, 5}, {}};
    cases.make = [&](std::size_t kind, std::uint64_t seed, int) -> std::string {
      ++made;
      if (kind == 1 && seed == 3) throw std::runtime_error("seed 3 is odd");
      return text_of({double(seed) / 3.0, kind == 1 ? NAN : 0.1});
    };
    return bench.results(cases, {}, code);
  }
  int made = 0, code = -1;
};

std::string lines_of(const std::vector<CaseBench::Result>& results) {
  std::string all;
  for (const CaseBench::Result& r : results)
    all += r.text + (r.made ? " made " : " failed ") + r.reason + "\n";
  return all;
}

}  // namespace

TEST_CASE("a bench in shards tells what it tells in one piece, and makes each case once") {
  CaseCalls whole;
  const auto expected = whole.run({});
  REQUIRE(expected);
  CHECK(expected->size() == 10);
  CHECK((*expected)[7].reason == "seed 3 is odd");
  const test::TempFolder folder;
  const std::string out = (folder.path() / "out").string();
  CaseCalls pieces;
  for (const char* shard : {"3/3", "1/3", "2/3"}) {
    CHECK_FALSE(pieces.run({"-o", out, "--shard", shard}));
    CHECK(pieces.code == kOk);
  }
  const auto merged = pieces.run({"-o", out});
  REQUIRE(merged);
  CHECK(pieces.made == 10);
  CHECK(lines_of(*merged) == lines_of(*expected));
  CHECK(pieces.run({"-o", out, "--again"}));
  CHECK(pieces.made == 11);
}

TEST_CASE("a bench that makes some cases goes on with the others, and its shards need a folder") {
  const test::TempFolder folder;
  const std::string out = (folder.path() / "out").string();
  CaseCalls bench;
  CHECK_FALSE(bench.run({"-o", out, "--max", "4"}));
  CHECK(bench.made == 4);
  CHECK(bench.run({"-o", out}));
  CHECK(bench.made == 10);
  CHECK_FALSE(bench.run({"--shard", "1/2"}));
  CHECK(bench.code == kUsage);
}

TEST_CASE("numbers of a case come back to the last bit, and no number as none") {
  const auto numbers = numbers_of(text_of({1.0 / 3.0, -0.0, 1e-320, NAN}));
  REQUIRE(numbers.size() == 4);
  CHECK(numbers[0] == 1.0 / 3.0);
  CHECK(numbers[2] == 1e-320);
  CHECK(std::isnan(numbers[3]));
}
