#include "files/record/spill.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <string>

#include "core/grid/random.h"

namespace firn::record {
namespace {

struct Entry {
  std::uint64_t number = 0;
  std::uint32_t square = 0;
};

Entry entry(std::size_t n) { return {n, std::uint32_t(n * n)}; }

bool same(const Entry& a, const Entry& b) { return a.number == b.number && a.square == b.square; }

/// Names another folder for temporary files, as long as it lives.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const char* folder) : was_(::getenv("TMPDIR") ? ::getenv("TMPDIR") : "") {
    ::setenv("TMPDIR", folder, 1);
  }
  ~TemporaryFolder() {
    if (was_.empty())
      ::unsetenv("TMPDIR");
    else
      ::setenv("TMPDIR", was_.c_str(), 1);
  }

 private:
  std::string was_;
};

bool reads_back(std::size_t entries) {
  Spill blocks(LongList<Entry>::kBlock_bytes);
  LongList<Entry> one(blocks), other(blocks);
  for (std::size_t n = 0; n < entries; ++n) {
    one.push_back(entry(n));
    if (n % 3 == 0) other.push_back(entry(n));
  }
  bool all = one.size() == entries;
  for (std::size_t n = 0; n < entries; ++n)
    all = all && same(one[n], entry(n)) && (n % 3 != 0 || same(other[n / 3], entry(n)));
  RandomStream random(1, Purpose::kTest);
  for (std::size_t k = 0; k < entries; ++k) {
    const std::size_t n = random.below(std::uint32_t(entries));
    all = all && same(one[n], entry(n));
  }
  return all;
}

TEST_CASE("a long list has its entries in any order of reading, beside another one in the same file") {
  const std::size_t block = LongList<Entry>::kBlock;
  for (const std::size_t entries : {std::size_t(1), block - 1, block, block + 1, 3 * block, 20 * block + 7})
    CHECK(reads_back(entries));
}

TEST_CASE("a long list stays in memory where no temporary file can be made") {
  const TemporaryFolder none("/nowhere");
  CHECK(reads_back(5000));
}

TEST_CASE("a long list goes on in memory where its temporary file grows no more") {
  rlimit was{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &was) == 0);
  auto* const before = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{3 * LongList<Entry>::kBlock_bytes + 100, was.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const bool all = reads_back(5000);
  ::setrlimit(RLIMIT_FSIZE, &was);
  std::signal(SIGXFSZ, before);
  CHECK(all);
}

}  // namespace
}  // namespace firn::record
